"""What happens to clients of a service: a newer bank, and lost connections."""

from __future__ import annotations

import shutil
from pathlib import Path

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.service.front import Front


def newer_bank(clip_folder: Path, folder: Path) -> Bank:
    """Builds a bank whose run is another one."""
    shutil.copytree(clip_folder, folder / "clips")
    (folder / "clips" / "run.bvh").write_bytes(dump_bvh(make("run", seed=12, seconds=4.0)))
    build_bank([folder / "clips"], folder / "bank", baseline="walk", jobs=1)
    return Bank.open(folder / "bank")


def lose(front: Front) -> None:
    """Closes all WebSockets, in the service's thread."""
    for one in front.hub.connections:
        one.close(1011, "lost")
