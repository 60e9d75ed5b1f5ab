"""uvicorn's configuration for the service, with our protocols."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from functools import partial
from multiprocessing.connection import wait
from pathlib import Path

from motionsplice.runtime.bank import Bank
from motionsplice.service.app import create_app
from motionsplice.service.edge.context import EdgeContext
from motionsplice.service.edge.http_protocol import HttpProtocol
from motionsplice.service.edge.websocket_protocol import WebSocketProtocol
from motionsplice.service.front import Front
from motionsplice.service.logs import log_config
from motionsplice.service.settings import Settings

STARTING = 60  # seconds that a worker may take to import everything, before which it answers no check of its health


def _application(path: Path, settings: Settings) -> Front:
    if parent := multiprocessing.parent_process():
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    return create_app(Bank.open(path, verify=False), settings)  # `serve` has verified it


def _end_with(sentinel: int) -> None:
    """Stops this worker when its parent process has ended, for any reason; it would keep the port otherwise."""
    wait([sentinel])
    os.kill(os.getpid(), signal.SIGTERM)


class EdgeConfig(EdgeContext):
    """The configuration of one process, or of several workers. It is pickled and sent to each worker."""

    def __init__(self, path: Path, settings: Settings) -> None:
        self.settings = settings
        super().__init__(
            partial(_application, path, settings),
            factory=True,
            workers=settings.workers,
            http=HttpProtocol,
            ws=WebSocketProtocol,
            ws_max_size=settings.max_message,
            ws_per_message_deflate=False,  # poses hardly shrink, and compressing takes 20 times as long as making them
            ws_ping_interval=settings.stall_seconds / 2.0,
            ws_ping_timeout=settings.stall_seconds / 2.0,
            timeout_keep_alive=settings.idle_seconds,  # type: ignore[arg-type]  # fractions work too
            timeout_graceful_shutdown=settings.stop_seconds,  # type: ignore[arg-type]
            timeout_worker_healthcheck=STARTING,  # uvicorn then kills it, and starts another
            proxy_headers=False,  # limits count real addresses, not those that clients claim
            server_header=False,
            access_log=False,  # the front logs refusals and failures
            log_config=log_config(),
        )
