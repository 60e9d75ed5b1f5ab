"""Runs scripts in Godot 3, and checks those for Godot 4."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

CLIENT = Path(__file__).parents[2] / "clients" / "godot"
GODOT = shutil.which("godot3-server")
MINUTES = 120.0  # seconds, far more than any script takes


def project(folder: Path) -> Path:
    """Writes a project of Godot 3 with the add-on and the scripts of its tests, as the README does."""
    addon = folder / "addons" / "motionsplice"
    addon.mkdir(parents=True)
    for file in (*(CLIENT / "shared").iterdir(), *(CLIENT / "godot3").iterdir()):
        shutil.copy(file, addon)
    for file in (CLIENT / "tests").iterdir():
        shutil.copy(file, folder)
    (folder / "project.godot").write_text("config_version=4\n")
    return folder


@contextmanager
def script(folder: Path, name: str, **variables: str) -> Iterator[subprocess.Popen[str]]:
    """Runs a script of a project."""
    assert GODOT is not None
    environment = {**os.environ, "HOME": str(folder), "LANG": "en_US.UTF-8", **variables}
    command = [GODOT, "--path", str(folder), "-s", name]
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        try:
            yield process
        finally:
            process.kill()
