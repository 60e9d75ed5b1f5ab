"""The service as an ASGI application."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.responses import RedirectResponse
from fastapi_offline import FastAPIOffline

from runtime.bank import Bank
from service import problems
from service.problems import Problem
from service.readiness import Readiness
from service.routes import bank_routes, health_routes
from service.settings import Settings

ABOUT = """Splices the upper body of any clip onto the lower body of any other.

Right-handed, Y up, Z forward; metres, seconds, unit quaternions xyzw. Rotations are in the parent's frame, the root's
in the world."""


def create_app(bank: Bank, settings: Settings | None = None) -> FastAPI:
    """An application that serves one bank. It is ready (`/readyz`) once the kernels are warm."""
    readiness = Readiness()

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        warming = asyncio.create_task(readiness.warm(bank))
        yield
        await warming

    # Its documentation pages bring their own scripts and styles, where FastAPI's own need the internet.
    app = FastAPIOffline(title="motionsplice", version="1", description=ABOUT, lifespan=lifespan)
    problems.install(app)
    app.include_router(bank_routes(bank, settings or Settings(), readiness))
    app.include_router(health_routes(readiness))

    app.openapi = lambda: _document(app, bank)  # type: ignore[method-assign]

    @app.get("/", include_in_schema=False)
    async def get_root() -> RedirectResponse:
        return RedirectResponse("docs")

    return app


def _document(app: FastAPI, bank: Bank) -> dict[str, Any]:
    """The OpenAPI document, with the schema of all error answers, and examples that this bank can answer."""
    if app.openapi_schema is None:
        document = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
        document["components"]["schemas"]["Problem"] = Problem.model_json_schema()
        examples = _examples(bank)
        for operations in document["paths"].values():
            for parameter in operations["get"].get("parameters", []):
                if parameter["name"] in examples:
                    parameter["example"] = examples[parameter["name"]]
        app.openapi_schema = document
    return app.openapi_schema


def _examples(bank: Bank) -> dict[str, str | float]:
    """What the interactive page fills in."""
    first = {clip.kind: clip.name for clip in reversed(bank.clips)}
    any_clip = bank.clips[0].name
    locomotion = first.get("locomotion", any_clip)
    return {"name": locomotion, "locomotion": locomotion, "action": first.get("action", any_clip), "time": 0.0}
