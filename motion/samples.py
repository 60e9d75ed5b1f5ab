"""The built-in motions as folders of clips."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.gestures import SAMPLE_HANDS, sample_gestures
from motionsplice.motion.procedural.library import ACTIONS, sample_clips


def write_sample_clips(folder: str | PathLike[str]) -> None:
    """Writes locomotions and actions as BVH files, with a `clips.toml` that states their kinds."""
    folder = Path(folder)
    _write(folder, sample_clips())
    entries = [f'[{name}]\nkind = "action"\nneutral = "walk"\n' for name in ACTIONS]
    (folder / "clips.toml").write_text("\n".join(entries))


def write_sample_gestures(folder: str | PathLike[str]) -> None:
    """Writes bodies that gesture, and the hands of each, with a `hands.toml` that pairs them."""
    folder = Path(folder)
    _write(folder, sample_gestures())
    entries = [
        f'[[hands]]\nbody = "{name}"\nhands = "{name}_hands"\nhand = "{hand}"\n' for name, hand in SAMPLE_HANDS.items()
    ]
    (folder / "hands.toml").write_text("\n".join(entries))


def _write(folder: Path, clips: Mapping[str, Clip]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, clip in clips.items():
        (folder / f"{name}.bvh").write_bytes(dump_bvh(clip))
