"""The viewer's modules: typed, tested in Node, and bundled as committed. Skipped without npm's packages."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

VIEWER = Path(__file__).parents[2] / "service" / "viewer"
pytestmark = pytest.mark.skipif(
    shutil.which("node") is None or not (VIEWER / "node_modules" / ".package-lock.json").exists(),
    reason="npm's packages are not installed: make viewer",
)


def run(*command: str) -> None:
    done = subprocess.run(command, cwd=VIEWER, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_types_are_right() -> None:
    run("npm", "run", "--silent", "check")


def test_modules_pass_their_own_tests() -> None:
    run("npm", "run", "--silent", "test")


def test_the_bundles_are_those_of_the_sources(tmp_path: Path) -> None:
    run("node", "build.mjs", str(tmp_path))
    for built in tmp_path.iterdir():
        committed = VIEWER / "page" / "vendor" / built.name
        assert built.read_bytes() == committed.read_bytes(), f"{built.name} is not what `make viewer` builds"
