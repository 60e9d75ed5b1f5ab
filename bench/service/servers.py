"""Servers as processes of their own on a free port of this machine, and what they take of it."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import psutil
from prometheus_client.parser import text_string_to_metric_families

from motion.errors import SettingsError

PROJECT = Path(__file__).parents[2]
SERVE = "from motionsplice.cli import main; main()"
PATIENCE = 120.0  # seconds: kernels may have to be compiled
MARK = "http://127.0.0.1:"  # after which a server says its port


@dataclass(frozen=True)
class Endpoint:
    """A server that runs: its port and its process."""

    port: int
    pid: int

    @property
    def cpu_seconds(self) -> float:
        """All that its process has computed, the system's part for it included."""
        times = psutil.Process(self.pid).cpu_times()
        return times.user + times.system

    @property
    def memory(self) -> int:
        """Resident bytes."""
        return int(psutil.Process(self.pid).memory_info().rss)

    @property
    def descriptors(self) -> int:
        """Files and sockets that it has open."""
        return int(psutil.Process(self.pid).num_fds())

    def metrics(self) -> dict[tuple[str, str], float]:
        """Its numbers for Prometheus, by name and by the value of their only label, if there is one."""
        with urllib.request.urlopen(f"{MARK}{self.port}/metrics", timeout=PATIENCE) as answer:
            families = text_string_to_metric_families(answer.read().decode())  # type: ignore[no-untyped-call]
        return {(one.name, ",".join(one.labels.values())): one.value for family in families for one in family.samples}


def service(bank: Path, *flags: str) -> AbstractContextManager[Endpoint]:
    """The service, on a bank."""
    return started("-c", SERVE, "serve", str(bank), "--port", "0", *flags)


@contextmanager
def started(*arguments: str) -> Iterator[Endpoint]:
    """A Python process that says its port and answers /readyz; ended when left. Raises SettingsError if it does not."""
    with tempfile.TemporaryFile("w+") as log:  # a pipe that nobody reads would stop it
        process = subprocess.Popen([sys.executable, *arguments], stdout=log, stderr=subprocess.STDOUT, cwd=PROJECT)
        try:
            yield Endpoint(_ready_port(process, log), process.pid)
            if process.poll() is not None:
                raise _failed(process, log)
        finally:
            process.terminate()
            process.wait(PATIENCE)


def _ready_port(process: subprocess.Popen[bytes], log: IO[str]) -> int:
    deadline, port = time.monotonic() + PATIENCE, 0
    while time.monotonic() < deadline and process.poll() is None:
        said = _read(log).partition(MARK)[2]
        if "/" in said:
            port = int(said.partition("/")[0])
            if _is_ready(port):
                return port
        time.sleep(0.05)
    raise _failed(process, log)


def _is_ready(port: int) -> bool:
    try:
        urllib.request.urlopen(f"{MARK}{port}/readyz", timeout=PATIENCE).close()
    except OSError:
        return False
    return True


def _read(log: IO[str]) -> str:
    log.seek(0)
    return log.read()


def _failed(process: subprocess.Popen[bytes], log: IO[str]) -> SettingsError:
    state = "does not get ready" if process.poll() is None else f"ended with {process.returncode}"
    return SettingsError(f"a server {state}; the end of what it said:\n{_read(log)[-2000:]}")
