"""Running the service: its socket, and one process or several that share it."""

from __future__ import annotations

import os
import socket
import tempfile
from pathlib import Path

import uvicorn
from uvicorn.supervisors import Multiprocess

from motionsplice.motion.errors import SettingsError
from motionsplice.service.edge.config import EdgeConfig
from motionsplice.service.metrics import SHARED_FOLDER
from motionsplice.service.settings import Settings

BACKLOG = 2048
MOST_UNSENT = 1024 * 1024  # bytes that the kernel keeps for a slow client, so that it is soon known to be one


def listen(settings: Settings) -> socket.socket:
    """The socket that clients connect to. Raises SettingsError if it cannot be had."""
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
        problem = f"{settings.host}:{settings.port} cannot be listened on: {error.strerror or error}"
        raise SettingsError(problem, mend="Give another --host or --port, or end what listens there") from None
    return listener


def serve(path: Path, settings: Settings, listener: socket.socket) -> None:
    """Serves the bank at `path`, which was verified, until stopped."""
    if settings.workers == 1:
        uvicorn.Server(EdgeConfig(path, settings)).run(sockets=[listener])
        return
    with tempfile.TemporaryDirectory(prefix="motionsplice-metrics-") as folder:
        os.environ[SHARED_FOLDER] = folder
        try:
            Multiprocess(EdgeConfig(path, settings), sockets=[listener]).run()
        finally:
            del os.environ[SHARED_FOLDER]
