"""Folders that may not be written, also not by root, and processes that keep to it."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

WITHOUT_RIGHTS = ("setpriv", "--bounding-set=-dac_override,-dac_read_search")  # root ignores modes by these
NO_HOME = {"HOME": os.devnull, "XDG_CACHE_HOME": os.devnull, "NUMBA_CACHE_DIR": ""}


@contextmanager
def sealed(folder: Path) -> Iterator[None]:
    """Takes the right to write into a folder, and all folders in it, from everybody while the context lasts."""
    folders = [folder, *filter(Path.is_dir, folder.rglob("*"))]
    for one in folders:
        one.chmod(0o555)
    try:
        yield
    finally:
        for one in folders:
            one.chmod(0o755)


def run_without_rights(command: list[str], environment: Mapping[str, str]) -> str:
    """Returns the output of a command for which modes of folders hold, and which has no home. It must succeed."""
    if os.getuid() == 0:
        if not shutil.which("setpriv"):
            pytest.skip("there is no setpriv, and modes of folders mean nothing to root")
        command = [*WITHOUT_RIGHTS, *command]
    done = subprocess.run(command, env={**os.environ, **NO_HOME, **environment}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout
