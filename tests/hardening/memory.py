"""A folder in memory: on a disk, writing a file takes longer than reading it, and each sync takes milliseconds."""

from __future__ import annotations

from pathlib import Path

IN_MEMORY = Path("/dev/shm") if Path("/dev/shm").is_dir() else None  # of Linux; None is the system's folder
