"""The built-in motions as a folder of clips."""

from __future__ import annotations

from pathlib import Path

from motion.formats.bvh import dump
from motion.procedural.library import ACTIONS, sample_clips


def write_sample_clips(folder: Path) -> None:
    """Writes them as BVH files, with the `clips.toml` that tells actions from locomotions."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, clip in sample_clips().items():
        (folder / f"{name}.bvh").write_bytes(dump(clip))
    entries = [f'[{name}]\nkind = "action"\nneutral = "walk"\n' for name in ACTIONS]
    (folder / "clips.toml").write_text("\n".join(entries))
