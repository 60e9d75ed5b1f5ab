"""Errors as problem+json (RFC 9457)."""

from __future__ import annotations

from http import HTTPStatus

import orjson
from pydantic import BaseModel, Field

from motionsplice.motion.errors import BankError, MotionError, SettingsError, TimeRangeError, UnknownClipError

MEDIA_TYPE = "application/problem+json"
URN = "urn:motionsplice:"


class RequestError(MotionError):
    """A parameter, key or command that is unknown, missing or invalid."""


class LimitError(MotionError):
    """The request exceeds a limit of the service."""


class TooLargeError(MotionError):
    """A body with more bytes than the service accepts."""


class TooSlowError(MotionError):
    """A body that does not arrive in time."""


class MediaTypeError(MotionError):
    """A body of an unsupported type."""


class RigError(MotionError):
    """A rig that a clip cannot be put onto."""


class NotReadyError(MotionError):
    """A request for poses before the kernels are compiled."""


class BusyError(MotionError):
    """The service is at capacity: too many streams or characters."""


class UploadError(MotionError):
    """An upload to a service that does not accept clips."""


class UnknownBankError(MotionError):
    """A bank or table that is not served, or not any more."""


class ReportError(MotionError):
    """A report that the service does not have, or that is not valid."""


class TokenError(MotionError):
    """A missing or wrong token."""


class OriginError(MotionError):
    """A web page whose origin is not allowed."""


class MethodError(MotionError):
    """A method that a path does not have."""


class UpgradeError(MotionError):
    """A plain request where a WebSocket is served."""


PROBLEMS: dict[type[MotionError], tuple[int, str]] = {
    TokenError: (401, "token"),
    OriginError: (403, "origin"),
    UploadError: (403, "uploads"),
    UnknownClipError: (404, "unknown-clip"),
    UnknownBankError: (404, "unknown-bank"),
    ReportError: (404, "report"),
    MethodError: (405, "http"),
    TooSlowError: (408, "timeout"),
    TooLargeError: (413, "too-large"),
    MediaTypeError: (415, "media-type"),
    TimeRangeError: (422, "time-range"),
    RequestError: (422, "request"),
    SettingsError: (422, "request"),
    LimitError: (422, "limit"),
    RigError: (422, "rig"),
    UpgradeError: (426, "http"),
    BusyError: (429, "busy"),
    BankError: (500, "failure"),
    NotReadyError: (503, "not-ready"),
    MotionError: (422, "clip"),
}


class Problem(BaseModel):
    """An error: what is wrong, and what to do."""

    type: str = Field(examples=[URN + "unknown-clip"])
    title: str = Field(examples=["Not Found"])
    status: int = Field(examples=[404])
    detail: str = Field(examples=["the bank has no clip 'wlak'. Did you mean 'walk'?"])
    request_id: str = Field(examples=["5f3a9c0e"], description="The id under which the service's log lists the request")


def at_most(name: str, given: float, most: float) -> None:
    """Checks a number against a limit. Raises LimitError if it is larger."""
    if given > most:
        raise LimitError(f"{name}: {given:g} is more than {most:g}", mend=f"Ask for at most {most:g}")


def stopping() -> NotReadyError:
    """Returns the error for a request that cannot be answered because the service stops."""
    return NotReadyError("the service is stopping", mend="Send the request again later, or to another service")


def kind_of(error: MotionError) -> tuple[int, str]:
    """Returns the HTTP status and the problem type of an error."""
    return next(PROBLEMS[kind] for kind in type(error).__mro__ if kind in PROBLEMS)


def problem(status: int, kind: str, detail: str, request_id: str) -> bytes:
    """Returns a problem as JSON."""
    return orjson.dumps(
        {
            "type": URN + kind,
            "title": HTTPStatus(status).phrase,
            "status": status,
            "detail": detail,
            "request_id": request_id,
        }
    )
