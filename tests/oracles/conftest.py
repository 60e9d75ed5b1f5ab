from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def ask() -> Callable[[str, Any], Any]:
    """Gives a script of this folder a JSON value, and returns the one that it prints; skips the test without Node."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("Node is not installed")
    if not (HERE / "node_modules").is_dir():
        pytest.skip("three.js is not installed: run npm ci --prefix tests/oracles")

    def run(script: str, question: Any) -> Any:
        command, text = [node, str(HERE / script)], json.dumps(question)
        done = subprocess.run(command, input=text, capture_output=True, text=True, check=False, timeout=120)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run
