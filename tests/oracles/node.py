"""Runs the scripts in this folder by Node."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
INSTALL = "its packages are not installed: npm ci --prefix tests/oracles"
MISSING = (
    "Node is not installed" if shutil.which("node") is None else "" if (HERE / "node_modules").is_dir() else INSTALL
)
needs_node = pytest.mark.skipif(bool(MISSING), reason=MISSING)


def run(script: str, *arguments: object) -> list[Any]:
    """Runs a script, and returns what its lines of JSON say."""
    command = ["node", str(HERE / script), *(str(argument) for argument in arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]
