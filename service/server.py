"""Runs the service: its socket, and the process or processes that share it."""

from __future__ import annotations

import logging
import os
import socket
import tempfile
from pathlib import Path

import uvicorn
from uvicorn.supervisors import Multiprocess

from motionsplice.motion.errors import SettingsError
from motionsplice.service.edge.config import EdgeConfig
from motionsplice.service.metrics import SHARED_FOLDER
from motionsplice.service.settings import Settings, unknown_variables

logger = logging.getLogger(__name__)

BACKLOG = 2048
MOST_UNSENT = 1024 * 1024  # bytes that the kernel buffers for a client; few, so that a slow one is soon noticed


def listen(settings: Settings) -> socket.socket:
    """Returns the socket that clients connect to. Raises SettingsError if the address cannot be used."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    listener = socket.socket(family)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if hasattr(socket, "TCP_USER_TIMEOUT"):  # Linux; connections inherit both
            listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, round(1000 * settings.stall_seconds))
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MOST_UNSENT)
        listener.bind((settings.host, settings.port))
        listener.listen(BACKLOG)
    except OSError as error:
        listener.close()
        problem = f"cannot listen on {settings.host}:{settings.port}: {error.strerror or error}"
        raise SettingsError(problem, mend="Choose another --host or --port") from None
    return listener


def serve(path: Path, settings: Settings, listener: socket.socket) -> None:
    """Serves the bank at `path` until stopped. The caller has verified the bank."""
    config = EdgeConfig(path, settings)  # which sets up the log
    if unknown := unknown_variables(os.environ):
        logger.warning("variables of the environment that are no settings have no effect", extra={"variables": unknown})
    if settings.workers == 1:
        uvicorn.Server(config).run(sockets=[listener])
        return
    with tempfile.TemporaryDirectory(prefix="motionsplice-metrics-") as folder:
        os.environ[SHARED_FOLDER] = folder
        try:
            Multiprocess(config, sockets=[listener]).run()
        finally:
            del os.environ[SHARED_FOLDER]
