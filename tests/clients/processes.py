"""Programs of clients, which print a map of JSON a line."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

MINUTES = 120.0  # seconds, far more than any program takes


@contextmanager
def started(*command: object) -> Iterator[Callable[[], dict[str, Any]]]:
    """Runs a program, and gives the function that returns the next map that it prints. It must end without an error."""
    with subprocess.Popen([*map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        output, errors = process.stdout, process.stderr
        assert output is not None
        assert errors is not None

        def line() -> dict[str, Any]:
            text = output.readline()
            assert text, errors.read()
            return dict(json.loads(text))

        try:
            yield line
            assert process.wait(MINUTES) == 0, errors.read()
        finally:
            process.kill()
