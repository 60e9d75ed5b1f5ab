"""Errors as problem+json (RFC 9457)."""

from __future__ import annotations

from collections.abc import Mapping
from http import HTTPStatus

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel
from starlette.exceptions import HTTPException

from motion.errors import MotionError, UnknownClipError


class Problem(BaseModel):
    """What went wrong, and what to do about it."""

    type: str
    title: str
    status: int
    detail: str


def install(app: FastAPI) -> None:
    """Makes the app answer every error with a problem."""
    app.add_exception_handler(MotionError, _motion_problem)
    app.add_exception_handler(RequestValidationError, _request_problem)
    app.add_exception_handler(HTTPException, _http_problem)
    app.add_exception_handler(Exception, _defect)


def answer(kind: str, status: int, detail: str, headers: Mapping[str, str] | None = None) -> JSONResponse:
    """A problem as a response."""
    problem = Problem(type=f"about:blank#{kind}", title=HTTPStatus(status).phrase, status=status, detail=detail)
    return JSONResponse(problem.model_dump(), status, headers, media_type="application/problem+json")


async def _motion_problem(_: Request, error: Exception) -> JSONResponse:
    status = HTTPStatus.NOT_FOUND if isinstance(error, UnknownClipError) else HTTPStatus.UNPROCESSABLE_ENTITY
    return answer(type(error).__name__, status, str(error))


async def _request_problem(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    wrong = [f"{'.'.join(map(str, one['loc'][1:]))}: {one['msg']}" for one in error.errors()]
    return answer("RequestError", HTTPStatus.UNPROCESSABLE_ENTITY, "; ".join(wrong))


async def _http_problem(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    return answer("HTTPError", error.status_code, str(error.detail), error.headers)


async def _defect(_: Request, __: Exception) -> JSONResponse:
    """What no client caused; the server logs it."""
    detail = "the service failed; its log says how"
    return answer("ServiceError", HTTPStatus.INTERNAL_SERVER_ERROR, detail)
