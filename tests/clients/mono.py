"""Compiles and runs programs in C# with mono."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from tests.clients import processes

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests" / "golden" / "files"
SOURCES = [*(ROOT / "clients" / "csharp").rglob("*.cs"), *(ROOT / "tests" / "clients" / "csharp").glob("*.cs")]
MISSING = shutil.which("mcs") is None or shutil.which("mono") is None
needs_mono = pytest.mark.skipif(MISSING, reason="mono is not installed: apt-get install mono-mcs mono-runtime")


def compiled(file: Path, sources: list[Path]) -> Path:
    """Compiles a program without a warning, and returns it."""
    references = [f"-r:{name}.dll" for name in ("System.Core", "System.Numerics", "System.Numerics.Vectors")]
    command = ["mcs", "-langversion:7.2", "-warnaserror", f"-out:{file}", *references, *map(str, sources)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return file


def printed(program: Path, *arguments: object, lines: list[str] | None = None) -> list[dict[str, Any]]:
    """Runs the program, and returns the maps that it prints."""
    command = ["mono", "--debug", str(program), *map(str, arguments)]
    text = "\n".join(lines or [])
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False, timeout=processes.MINUTES)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def started(program: Path, *arguments: object) -> AbstractContextManager[Callable[[], dict[str, Any]]]:
    """Runs the program, and gives the function that returns the next map that it prints."""
    return processes.started("mono", "--debug", program, *arguments)
