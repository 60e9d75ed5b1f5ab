"""The clips that benchmarks run on: the built-in motions, or a folder of captured clips."""

from __future__ import annotations

from pathlib import Path

from motionsplice.motion.clip_settings import FILE_NAME
from motionsplice.motion.samples import write_sample_clips
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank

REAL_CLIP = "06_02.bvh"
REAL_SETTINGS = Path(__file__).with_name("real_clips.toml")


def bank_of(clips: Path | None, baseline: str | None, folder: Path) -> Bank:
    """Builds a bank below `folder` from the clips in `clips`, or from the built-in motions, and opens it."""
    folder.mkdir(exist_ok=True)
    linked = folder / "clips"
    if clips is None:
        write_sample_clips(linked)
    else:
        link(clips, linked)
    build_bank([linked], folder / "bank", baseline=baseline)
    return Bank.open(folder / "bank")


def link(clips: Path, folder: Path) -> None:
    """Links the files of the folder `clips` into `folder`.

    If these are the captured clips that REAL_SETTINGS describes, and they have no settings yet, adds REAL_SETTINGS.
    """
    folder.mkdir()
    for file in clips.iterdir():
        (folder / file.name).symlink_to(file.resolve())
    if (clips / REAL_CLIP).exists() and not (clips / FILE_NAME).exists():
        (folder / FILE_NAME).write_text(REAL_SETTINGS.read_text())
