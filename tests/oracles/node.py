"""Runs the scripts in this folder by Node."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
HAS_NODE = shutil.which("node") is not None and (HERE / "node_modules").is_dir()
needs_node = pytest.mark.skipif(not HAS_NODE, reason="needs Node, and `npm install` in tests/oracles")


def run(script: str, *arguments: object) -> list[Any]:
    """Runs a script, and returns what its lines of JSON say."""
    command = ["node", str(HERE / script), *(str(argument) for argument in arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]
