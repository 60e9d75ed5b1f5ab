"""Assembles the service: the front answers what games request every tick, FastAPI the rest."""

from __future__ import annotations

import asyncio
import gc
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from http import HTTPStatus

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import RedirectResponse, Response
from fastapi_offline import FastAPIOffline
from starlette.exceptions import HTTPException
from starlette.routing import Match, Mount
from starlette.types import Scope

from motionsplice.motion.errors import MotionError
from motionsplice.runtime.bank import Bank
from motionsplice.service.admission import address_of
from motionsplice.service.exchange.job import Job
from motionsplice.service.exchange.leases import Leases
from motionsplice.service.exchange.routes import exchange_routes
from motionsplice.service.exchange.watch import watch
from motionsplice.service.front import Front, allowed, no_method
from motionsplice.service.logs import request_id
from motionsplice.service.metrics import Metrics
from motionsplice.service.openapi.document import document
from motionsplice.service.openapi.pages import TITLE, documentation_routes
from motionsplice.service.problems import MEDIA_TYPE, kind_of, problem
from motionsplice.service.refusals import WITH_STATUS
from motionsplice.service.routes import bank_routes, health_routes
from motionsplice.service.serving import Edition, Serving
from motionsplice.service.settings import Settings
from motionsplice.service.shared import Shared
from motionsplice.service.viewer.routes import viewer_routes


def create_app(bank: Bank, settings: Settings | None = None) -> Front:
    """Returns an ASGI application that serves a bank. It is ready (`/readyz`) once the kernels are compiled."""
    settings = settings or Settings()
    leases = Leases(settings.copies)
    shared = Shared(settings, Serving(leases.hold(bank)), Metrics())  # nothing reads the tables before they are held
    clips = settings.clips if settings.token is not None else None
    job = Job(clips, bank.path) if clips is not None else None
    shared.serving.listeners.append(lambda edition: shared.metrics.serves(edition.bank.digest))

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        tasks = [asyncio.create_task(one) for one in (_warm(shared.serving), front.hub.run(), leases.keep())]
        if shared.settings.watch or job is not None:
            tasks.append(asyncio.create_task(watch(shared.serving, shared.metrics, leases)))
        if job is not None:
            tasks.append(asyncio.create_task(job.run()))
        yield
        front.begin_stop()  # if no connection was open, nothing else has
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    # Serves the scripts and styles of the documentation pages itself; those of FastAPI come from the internet.
    app = FastAPIOffline(
        title=TITLE,
        lifespan=lifespan,
        generate_unique_id_function=lambda route: route.name,
        docs_url=None,  # its own pages link to absolute paths
        redoc_url=None,
        redirect_slashes=False,  # redirects are to http://, whatever a proxy in front serves
    )
    front = Front(shared, app)
    app.include_router(bank_routes(shared))
    app.include_router(exchange_routes(shared, job))
    app.include_router(health_routes(shared))
    app.include_router(viewer_routes())
    app.include_router(documentation_routes())
    app.openapi = lambda: document(app, shared)  # type: ignore[method-assign]
    _add_problems(app, front)

    def discard_schema(_: Edition) -> None:
        app.openapi_schema = None  # its examples are from the previous bank

    shared.serving.listeners.append(discard_schema)

    @app.get("/", include_in_schema=False)
    async def get_root() -> RedirectResponse:
        return RedirectResponse("view/")

    return front


async def _warm(serving: Serving) -> None:
    """Warms the kernels, and then excludes all objects that there are from collections of garbage.

    Half a million are those of imported modules. A full collection, which long lists of commands set off, visited them
    for 90 ms.
    """
    await serving.warm()
    gc.collect()
    gc.freeze()


def _add_problems(app: FastAPI, front: Front) -> None:
    """Makes FastAPI answer and log errors as the front does."""

    def refuse(request: Request, status: int, kind: str, detail: str) -> Response:
        front.shared.refusals.note(request_id.get(), address_of(request.scope), status, detail, request.scope["path"])
        return _problem(status, kind, detail)

    async def motion_problem(request: Request, error: Exception) -> Response:
        assert isinstance(error, MotionError)
        status, kind = kind_of(error)
        answer = refuse(request, status, kind, str(error))
        answer.raw_headers.extend(WITH_STATUS.get(status, []))
        return answer

    async def request_problem(request: Request, error: Exception) -> Response:
        assert isinstance(error, RequestValidationError)
        wrong = [f"{'.'.join(map(str, one['loc'][1:]))}: {one['msg']}" for one in error.errors()]
        return refuse(request, 422, "request", "; ".join(wrong))

    async def http_problem(request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        headers, path = dict(error.headers or {}), request.scope["path"]
        detail = str(error.detail)
        if detail == HTTPStatus.NOT_FOUND.phrase:  # Starlette says no more
            detail = f"no such path {path[:80]!r}. {_other_path(app, front, request.scope)}"
        if detail == HTTPStatus.METHOD_NOT_ALLOWED.phrase:
            detail = str(no_method(request.method, path, headers["Allow"]))
            headers["Allow"] = allowed(path, headers["Allow"])
        answer = refuse(request, error.status_code, "http", detail)
        answer.headers.update(headers)
        return answer

    app.add_exception_handler(MotionError, motion_problem)
    app.add_exception_handler(RequestValidationError, request_problem)
    app.add_exception_handler(HTTPException, http_problem)
    app.add_exception_handler(Exception, _failure)


def _other_path(app: FastAPI, front: Front, scope: Scope) -> str:
    """Returns what to request instead of an unknown path: the same without slashes too many, if there is such a one."""
    path = "/" + "/".join(filter(None, scope["path"].split("/")))
    routes = [route for route in app.router.routes if not isinstance(route, Mount)]
    if path in front.paths or any(route.matches({**scope, "path": path})[0] != Match.NONE for route in routes):
        return f"Use {path[:80]!r}"
    return "GET /openapi.json lists all requests"


async def _failure(_: Request, __: Exception) -> Response:
    return _problem(500, "failure", "the service failed; see its log")


def _problem(status: int, kind: str, detail: str) -> Response:
    return Response(problem(status, kind, detail, request_id.get()), status, media_type=MEDIA_TYPE)
