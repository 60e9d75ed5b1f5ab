"""The pages /docs and /redoc. Their links are relative, so that a proxy may serve them below a path of its own."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.openapi.docs import get_redoc_html, get_swagger_ui_html
from fastapi.responses import HTMLResponse

TITLE, DOCUMENT, STATIC = "motionsplice", "openapi.json", "static-offline-docs"  # beside the pages, as they are routed
ICON = f"{STATIC}/favicon.png"
# Redoc would load its logo from its maker's host
POLICY = {
    "content-security-policy": "default-src 'self' 'unsafe-inline'; img-src 'self' data:; worker-src 'self' blob:; "
    "frame-ancestors 'none'"
}


def documentation_routes() -> APIRouter:
    """Returns the routes of the pages. The scripts and styles are those of FastAPIOffline."""
    router = APIRouter(include_in_schema=False)

    @router.get("/docs")
    async def get_docs() -> HTMLResponse:
        page = get_swagger_ui_html(
            openapi_url=DOCUMENT,
            title=TITLE,
            swagger_js_url=f"{STATIC}/swagger-ui-bundle.js",
            swagger_css_url=f"{STATIC}/swagger-ui.css",
            swagger_favicon_url=ICON,
        )
        page.headers.update(POLICY)
        return page

    @router.get("/redoc")
    async def get_redoc() -> HTMLResponse:
        page = get_redoc_html(
            openapi_url=DOCUMENT,
            title=TITLE,
            redoc_js_url=f"{STATIC}/redoc.standalone.js",
            redoc_favicon_url=ICON,
            with_google_fonts=False,
        )
        page.headers.update(POLICY)
        return page

    return router
