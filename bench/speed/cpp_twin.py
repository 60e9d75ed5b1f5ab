"""The evaluator of clients/cpp, compiled for this machine as a library that is timed."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

MISSING = "" if shutil.which("g++") else "g++ is not installed"
OPTIONS = ["-std=c++17", "-O3", "-march=native", "-fno-exceptions", "-fno-rtti", "-shared", "-fPIC"]


def compiled(folder: Path) -> Path:
    """Compiles the library into `folder`, and returns its path."""
    library = folder / "twin.so"
    subprocess.run(["g++", *OPTIONS, Path(__file__).with_suffix(".cpp"), "-o", library], check=True)
    return library
