"""The command `serve` in a process: workers, signals, logs."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import threading
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from unittest.mock import MagicMock

import pytest
from uvicorn.config import STARTUP_FAILURE
from uvicorn.supervisors import Multiprocess
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.service.edge.config import EdgeConfig
from motionsplice.service.server import listen
from motionsplice.service.settings import Settings
from tests.service.running import COMPILING, PATIENCE, eventually

ROOT = Path(__file__).parents[2]


@contextmanager
def served(bank: Bank, log: Path, *flags: str, **variables: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    command = [sys.executable, "-m", "motionsplice", "serve", str(bank.path), "--port", "0", *flags]
    with (
        log.open("w") as errors,
        subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            cwd=ROOT,
            env={**os.environ, "COLUMNS": "200"} | variables,
        ) as server,
    ):
        try:
            assert server.stdout is not None
            for line in server.stdout:
                if found := re.search(r"(http://127\.0\.0\.1:\d+)/view", line):
                    break
            assert found is not None
            url = found.group(1)
            eventually(lambda: all(_status(f"{url}/readyz") == 204 for _ in range(20)), COMPILING)  # of all workers
            yield server, url
        finally:
            server.kill()


def _status(url: str) -> int:
    try:
        with urllib.request.urlopen(url, timeout=PATIENCE) as answer:
            return int(answer.status)
    except OSError:
        return 0


def test_workers_share_a_port_and_metrics_and_stop_together(bank: Bank, tmp_path: Path) -> None:
    log = tmp_path / "log"
    with served(bank, log, "--workers", "2", "--stop-seconds", "1", MOTIONSPLICE_MAX_RATES="9") as (server, url):
        for _ in range(30):
            assert _status(f"{url}/v1/pose?locomotion=walk&time=1") == 200
        _status(f"{url}/v1/pose?locomotion=wlak&time=1")
        metrics = urllib.request.urlopen(f"{url}/metrics", timeout=PATIENCE).read().decode()
        assert 'motionsplice_requests_total{route="/v1/pose",status="200"} 30.0' in metrics
        with connect(url.replace("http", "ws") + "/v1/characters", compression=None) as client:
            client.send('{"do": "create", "id": 1, "locomotion": "walk"}')
            server.send_signal(signal.SIGTERM)
            while '"closing"' not in str(client.recv(timeout=PATIENCE)):
                pass
            with pytest.raises(ConnectionClosed) as caught:
                client.recv(timeout=PATIENCE)
            assert caught.value.rcvd is not None
            assert caught.value.rcvd.code == 1012
        assert server.wait(PATIENCE) == 0
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    (unknown,) = [line for line in lines if line["level"] == "warning" and "variables" in line]
    assert unknown["variables"] == ["MOTIONSPLICE_MAX_RATES"]
    for message in ("starting", "ready", "stopping"):
        of_workers = [line for line in lines if line["message"] == message]
        assert [line["bank"] for line in of_workers] == [bank.digest] * 2
        assert all(line.keys() >= {"time", "level", "logger"} for line in of_workers)
    assert all(line["seconds"] > 0.0 for line in lines if line["message"] == "ready")
    (refused,) = [line for line in lines if line["message"] == "refused" and line["path"] != "/readyz"]
    assert refused["status"] == 404
    assert refused["request_id"]
    assert "wlak" in refused["detail"]


def test_a_worker_that_is_killed_is_replaced_and_its_connections_are_forgotten(bank: Bank, tmp_path: Path) -> None:
    with served(bank, tmp_path / "log", "--workers", "2") as (server, url), ExitStack() as opened:
        address = url.replace("http", "ws") + "/v1/characters"
        clients = [opened.enter_context(connect(address, compression=None)) for _ in range(8)]
        workers = _workers(server.pid)
        assert len(workers) == 2
        eventually(lambda: _connections(url) == 8)
        os.kill(workers[0], signal.SIGKILL)
        eventually(lambda: len({*_workers(server.pid)} - {workers[0]}) == 2)
        alive = [client for client in clients if _answers(client)]
        eventually(lambda: _connections(url) == len(alive))
        eventually(lambda: all(_status(f"{url}/v1/pose?locomotion=walk&time=1") == 200 for _ in range(20)))


def _workers(server: int) -> list[int]:
    """Returns the processes that a service has started to serve; one that ends while it is listed is left out."""
    workers = []
    for one in Path(f"/proc/{server}/task/{server}/children").read_text().split():
        with suppress(FileNotFoundError, ProcessLookupError):
            if b"spawn_main" in Path(f"/proc/{one}/cmdline").read_bytes():
                workers.append(int(one))
    return workers


def _connections(url: str) -> float:
    """Returns how many WebSockets all workers together have. A worker that had none so far says nothing of them."""
    metrics = urllib.request.urlopen(f"{url}/metrics", timeout=PATIENCE).read().decode()
    return sum(map(float, re.findall(r'motionsplice_connections{kind="characters"} ([0-9.]+)', metrics)))


def _answers(client: ClientConnection) -> bool:
    try:
        client.send('{"do": "set", "rate": 10}')
        while '"done"' not in str(client.recv(timeout=PATIENCE)):
            pass
    except ConnectionClosed:
        return False
    return True


def test_a_port_in_use_is_an_error(bank: Bank) -> None:
    with listen(Settings(port=0)) as listener, pytest.raises(SettingsError, match=r"cannot listen on 127\.0\.0\.1:"):
        listen(Settings(port=listener.getsockname()[1]))


def test_workers_that_take_long_to_start_are_not_killed(bank: Bank) -> None:
    """On a machine with three times as much to do as it can, a worker took 13 s to import everything."""
    supervisor, ends = MagicMock(config=EdgeConfig(bank.path, Settings(workers=2))), threading.Event()
    worker = MagicMock(is_alive=lambda timeout: timeout > 30.0, exitcode=STARTUP_FAILURE)
    supervisor.processes, supervisor.should_exit = [worker], ends
    Multiprocess.keep_subprocess_alive(supervisor)
    assert not worker.kill.called
    assert not ends.is_set()
