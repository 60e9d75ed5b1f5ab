"""The log: lines of JSON, or lines of plain text on a terminal."""

from __future__ import annotations

import itertools
import logging
import logging.config
import os
import sys
from contextvars import ContextVar
from datetime import UTC, datetime
from typing import Any

import orjson

request_id: ContextVar[str] = ContextVar("request_id", default="")

OF_REQUESTS = frozenset(
    {
        "ASGI callable returned without completing response.",
        "Invalid HTTP request received.",
        "Unsupported upgrade request.",
    }
)
STANDARD_FIELDS = frozenset(vars(logging.makeLogRecord({}))) | {"message", "asctime", "color_message", "taskName"}


def request_ids() -> itertools.count[int]:
    """Returns a counter for request ids. It starts at a random number, so that ids of several processes differ."""
    return itertools.count(int.from_bytes(os.urandom(5), "big") << 16)


class JsonLines(logging.Formatter):
    """Formats a record as JSON: time, level, logger, message, request id and all extra fields."""

    def format(self, record: logging.LogRecord) -> str:
        fields: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        if identity := request_id.get():
            fields["request_id"] = identity
        fields |= _extra(record)
        if record.exc_info:
            fields["exception"] = self.formatException(record.exc_info)
        return orjson.dumps(fields, default=str).decode()


class Lines(logging.Formatter):
    """Formats a record as plain text."""

    def format(self, record: logging.LogRecord) -> str:
        extra = "".join(f" {key}={value}" for key, value in _extra(record).items())
        line = f"{self.formatTime(record, '%H:%M:%S')} {record.levelname.lower():7} {record.getMessage()}{extra}"
        return f"{line}\n{self.formatException(record.exc_info)}" if record.exc_info else line


class NoRequests(logging.Filter):
    """Leaves out what uvicorn logs about single requests. A flood of them would flood the log, and the front logs
    refusals itself. An answer without an end is how a client sees that a stream was cut."""

    def filter(self, record: logging.LogRecord) -> bool:
        return record.msg not in OF_REQUESTS


def log_config() -> dict[str, Any]:
    """Returns a configuration for logging.config that writes everything to stderr."""
    formatter = "motionsplice.service.logs.Lines" if sys.stderr.isatty() else "motionsplice.service.logs.JsonLines"
    return {
        "version": 1,
        "disable_existing_loggers": False,
        "formatters": {"lines": {"()": formatter}},
        "filters": {"no requests": {"()": NoRequests}},
        "handlers": {"stderr": {"class": "logging.StreamHandler", "formatter": "lines"}},
        "root": {"handlers": ["stderr"], "level": "INFO"},
        "loggers": {
            "uvicorn.error": {"level": "WARNING", "filters": ["no requests"]},
            "uvicorn.access": {"handlers": [], "propagate": False},
        },
    }


def _extra(record: logging.LogRecord) -> dict[str, Any]:
    return {key: value for key, value in vars(record).items() if key not in STANDARD_FIELDS}
