"""Serves the page's files. They hold nothing of the bank, so they need no token: the page asks for it."""

from __future__ import annotations

import gzip
import hashlib
import re
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import NamedTuple

from fastapi import APIRouter, Request
from fastapi.responses import RedirectResponse, Response
from starlette.exceptions import HTTPException

TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}  # Starlette adds UTF-8
METHODS = ["GET", "HEAD"]
PAGES = {"": "index.html", "report": "report.html"}  # by the path below /view/
VENDOR = "vendor/"  # bundles, which have no comments
COMMENTS = {
    # blocks, and types of expressions within a line: a fifth of what is sent
    ".js": re.compile(
        rb"^[ \t]*/\*\*(?:(?!\*/).)*\*/[ \t]*\n|/\*\* @type (?:(?!\*/).)*\*/ ?", re.DOTALL | re.MULTILINE
    ),
    ".css": re.compile(rb"/\*.*?\*/\n?", re.DOTALL),
}
HEADERS = {
    # nothing from other hosts, no inline scripts; blobs are pictures, recordings and textures that the page makes
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    "connect-src 'self' blob:; media-src blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cache-control": "no-cache",
    "vary": "accept-encoding",
}


class File(NamedTuple):
    """A file of the page, as it is and compressed."""

    plain: bytes
    compressed: bytes
    media_type: str
    etag: str


@cache
def page_files() -> dict[str, File]:
    """Returns the files of the page by their path below /view/."""
    return dict(_found(files(__name__.rpartition(".")[0]) / "page", ""))


def _found(folder: Traversable, path: str) -> list[tuple[str, File]]:
    found: list[tuple[str, File]] = []
    for one in sorted(folder.iterdir(), key=lambda one: one.name):
        suffix = one.name[one.name.rfind(".") :]
        if one.is_dir():
            found += _found(one, f"{path}{one.name}/")
        elif suffix in TYPES:
            data = one.read_bytes()
            if suffix in COMMENTS and not path.startswith(VENDOR):
                data = COMMENTS[suffix].sub(b"", data)
            etag = f'"{hashlib.blake2b(data, digest_size=16).hexdigest()}"'
            found.append((path + one.name, File(data, gzip.compress(data, mtime=0), TYPES[suffix], etag)))
    return found


def viewer_routes() -> APIRouter:
    """Returns the routes of the page."""
    router = APIRouter(include_in_schema=False)

    @router.api_route("/view", methods=METHODS)
    async def get_view(request: Request) -> RedirectResponse:
        return RedirectResponse(f"view/?{request.url.query}" if request.url.query else "view/")

    @router.api_route("/view/{path:path}", methods=METHODS)
    async def get_page(path: str, request: Request) -> Response:
        file = page_files().get(PAGES.get(path, path))
        if file is None:
            raise HTTPException(404, "the page has no such file")
        headers = {**HEADERS, "etag": file.etag}
        if request.headers.get("if-none-match") == file.etag:
            return Response(status_code=304, headers=headers)
        if "gzip" in request.headers.get("accept-encoding", ""):
            headers["content-encoding"] = "gzip"
            return Response(file.compressed, headers=headers, media_type=file.media_type)
        return Response(file.plain, headers=headers, media_type=file.media_type)

    return router
