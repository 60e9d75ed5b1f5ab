"""A server in a separate process, and what the operating system reports about it."""

from __future__ import annotations

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

TICKS = os.sysconf("SC_CLK_TCK")
PRIORITY = 10  # of processes that run before others: any real-time priority does
PATIENCE = 300.0  # seconds to wait, as kernels may have to be compiled


@dataclass(frozen=True)
class Process:
    """A running server."""

    pid: int
    port: int

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def cpu(self) -> float:
        """Returns the seconds of processor time used so far."""
        fields = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICKS

    def memory(self) -> float:
        """Returns its resident memory in megabytes."""
        found = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{self.pid}/status").read_text())
        return int(found.group(1)) / 1024.0 if found else 0.0

    def descriptors(self) -> int:
        """Returns the number of open files and sockets."""
        return len(os.listdir(f"/proc/{self.pid}/fd"))

    def get(self, path: str) -> Any:
        """Returns an answer in JSON. Raises OSError if there is none."""
        with urllib.request.urlopen(f"{self.url}{path}", timeout=PATIENCE) as answer:
            return json.load(answer)

    def metrics(self, *names: str) -> list[float]:
        """Returns numbers from one reading of /metrics, 0 for those that are missing."""
        with urllib.request.urlopen(f"{self.url}/metrics", timeout=PATIENCE) as answer:
            text = answer.read().decode()
        found = (re.search(rf"^{re.escape(name)} (\S+)$", text, re.MULTILINE) for name in names)
        return [float(one.group(1)) if one else 0.0 for one in found]

    def metric(self, name: str) -> float:
        """Returns a number from /metrics, 0 if it is missing."""
        return self.metrics(name)[0]


def prefer(pid: int) -> bool:
    """Lets a process run before all others, so that they do not count. Returns whether the system permits that."""
    try:
        os.sched_setscheduler(pid, os.SCHED_RR, os.sched_param(PRIORITY))
    except PermissionError:
        return False
    return True


@contextmanager
def serving(bank: Path, *flags: str) -> Iterator[Process]:
    """Starts the service with a bank on a free port, and waits until it is ready."""
    command = [sys.executable, "-m", "motionsplice", "serve", str(bank), "--port", "0", *flags]
    with _started(command, r"http://127\.0\.0\.1:(\d+)", "/readyz") as process:
        yield process


@contextmanager
def profiled(bank: Path, file: Path, *flags: str) -> Iterator[Process]:
    """Starts the same service under a profiler that writes to `file` (bench/service/profiled_server.py)."""
    command = [sys.executable, "-m", "bench.service.profiled_server", str(file), "serve", str(bank), "--port", "0"]
    with _started([*command, *flags], r"http://127\.0\.0\.1:(\d+)", "/readyz") as process:
        yield process


@contextmanager
def control(*arguments: str) -> Iterator[Process]:
    """Starts the control, a server that only sends (bench/service/control.py)."""
    command = [sys.executable, "-m", "bench.service.control", *arguments]
    with _started(command, r"port (\d+)", "/") as process:
        yield process


@contextmanager
def _started(command: list[str], port: str, path: str) -> Iterator[Process]:
    resource.setrlimit(resource.RLIMIT_NOFILE, (resource.getrlimit(resource.RLIMIT_NOFILE)[1],) * 2)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, bufsize=1) as server:
        assert server.stdout is not None
        try:
            found = next(filter(None, (re.search(port, line) for line in server.stdout)), None)
            if found is None:
                raise SystemExit(f"{' '.join(command)} ended with status {server.wait()}")
            process = Process(server.pid, int(found.group(1)))
            deadline = time.monotonic() + PATIENCE
            while not _answers(process.url + path):
                if time.monotonic() > deadline:
                    raise SystemExit(f"{process.url} was not ready after {PATIENCE:g} s")
                time.sleep(0.05)
            yield process
        finally:
            server.send_signal(signal.SIGTERM)
            try:
                server.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                server.kill()


def _answers(url: str) -> bool:
    try:
        urllib.request.urlopen(url, timeout=1.0).close()
    except OSError:
        return False
    return True
