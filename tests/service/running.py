"""A service on a free port of this machine, in a thread, for tests that need real sockets."""

from __future__ import annotations

import socket
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import uvicorn

from motionsplice.service.edge.config import EdgeConfig
from motionsplice.service.server import listen
from motionsplice.service.settings import Settings

PATIENCE = 120.0  # seconds, far more than any step takes, also on a machine that is busy
COMPILING = 1800.0  # if kernels are compiled for the first time, beside other work


class Running:
    """A running service, and access to its state."""

    def __init__(self, config: EdgeConfig, server: uvicorn.Server, port: int) -> None:
        self.config = config
        self.server = server
        self.port = port
        self.url = f"http://127.0.0.1:{port}"
        self.peers: list[socket.socket] = []

    def connect(self, *sent: bytes, receive_buffer: int | None = None) -> socket.socket:
        """Connects, sends bytes, and returns the socket, which is closed when the service ends."""
        peer = socket.socket()
        self.peers.append(peer)
        if receive_buffer is not None:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        peer.settimeout(PATIENCE)
        peer.connect(("127.0.0.1", self.port))
        for one in sent:
            peer.sendall(one)
        return peer

    @property
    def held(self) -> tuple[int, int, int, int]:
        """Numbers of connections in the ledger and in uvicorn, of tasks, and of streams."""
        state, front = self.server.server_state, self.config.front
        return len(self.config.ledger), len(state.connections), len(state.tasks), len(front.shared.streams)


def eventually(holds: Callable[[], bool], patience: float = PATIENCE) -> None:
    """Waits until a condition holds, and fails after `patience` seconds."""
    deadline = time.monotonic() + patience
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def received(peer: socket.socket) -> bytes:
    """Returns all bytes received until the connection is closed, and closes the socket."""
    chunks = []
    with peer, suppress(ConnectionResetError):
        while chunk := peer.recv(65536):
            chunks.append(chunk)
    return b"".join(chunks)


@contextmanager
def running(path: Path, settings: Settings, port: int = 0) -> Iterator[Running]:
    """Serves a bank while the context lasts, on a free port if none is given."""
    settings = settings.model_copy(update={"port": port})
    listener, config = listen(settings), EdgeConfig(path, settings)
    server, port = uvicorn.Server(config), listener.getsockname()[1]
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    service = Running(config, server, port)
    eventually(lambda: _is_ready(service), COMPILING)
    yield service
    server.should_exit = True
    thread.join(PATIENCE)
    for peer in service.peers:
        peer.close()
    assert not thread.is_alive()


def _is_ready(service: Running) -> bool:
    try:
        urllib.request.urlopen(f"{service.url}/readyz", timeout=1.0).close()
    except OSError:
        return False
    return True
