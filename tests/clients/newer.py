"""What clients must survive: a newer bank than that of `tests/conftest.py`, and lost connections."""

from __future__ import annotations

import shutil
from pathlib import Path

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.service.characters.hub import Hub


def newer_bank(clip_folder: Path, folder: Path) -> Bank:
    """Builds a bank whose run is another one."""
    shutil.copytree(clip_folder, folder / "clips")
    (folder / "clips" / "run.bvh").write_bytes(dump_bvh(make("run", seed=12, seconds=4.0)))
    build_bank([folder / "clips"], folder / "bank", baseline="walk", jobs=1)
    return Bank.open(folder / "bank")


def lose_connections(hub: Hub) -> None:
    """Closes all connections, on the service's event loop, as a network that fails does."""
    for connection in list(hub.connections):
        connection.close(1011, "lost")
