"""Sanity checks for all other numbers: `python -m bench.quality.identities [CLIPS]`.

For each clip, prints four checks, of the papers' exact method and of the bank:
- how far the clip spliced onto itself is from the clip;
- how well a known time warp is recovered;
- how much the result changes when the local frames of all joints are turned at random;
- how large the accelerations are in the seam past the clip's end (bank only).
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.clips import bank_of
from bench.quality.measures import accelerations
from motionsplice.cli import run
from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.variants import local_axes, uneven_time, warped, with_local_axes
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.rig import Rig
from motionsplice.precompute.alignment.baseline import find_baseline
from motionsplice.precompute.alignment.working_rate import WORKING_RATE
from motionsplice.precompute.job.bank_builder import write_bank
from motionsplice.precompute.preparation.prepared import prepare
from motionsplice.precompute.splice import align_in_time, splice_exact
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.runtime.splice import Splice


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of clips; default: the built-in motions")] = None,
    baseline: Annotated[str | None, typer.Option(help="Baseline clip")] = None,
) -> None:
    """Prints one row of checks per clip."""
    table = Table(
        title="Largest distances in mm; warp errors in frames at 30 Hz (median / 95th percentile)",
        caption="seam: largest acceleration in the seam / 99th percentile of the clip",
    )
    for column in (
        "clip",
        "self exact",
        "self bank",
        "warp exact",
        "warp bank",
        "local axes exact",
        "local axes bank",
        "seam",
    ):
        table.add_column(column, justify="right")
    with tempfile.TemporaryDirectory() as folder:
        bank = bank_of(clips, baseline, Path(folder))
        evaluator = Evaluator(bank)
        ring_clip = bank.motion(bank.baseline.clip)
        for entry in bank.clips:
            clip = bank.motion(entry.name)
            own = splice_exact(clip, clip, bank.roles).clip
            frames = uneven_time(clip.frame_count)
            uneven = warped(clip, frames, "uneven")
            small = _bank(Path(folder) / "small", bank, ring_clip, clip, uneven)
            pairwise = align_in_time(uneven, clip, bank.roles)[1]
            working = WORKING_RATE / clip.rate
            axes = local_axes(bank.skeleton.joint_count, seed=1)
            pair = ring_clip, clip
            turned = with_local_axes(ring_clip, axes), with_local_axes(clip, axes)
            exact = [splice_exact(a, b, bank.roles, posture="absolute").clip for a, b in (pair, turned)]
            banks = [_bank(Path(folder) / f"axes{n}", bank, *both) for n, both in enumerate((pair, turned))]
            splice = [Evaluator(one).clip(Splice(ring_clip.name, entry.name, posture="absolute")) for one in banks]
            table.add_row(
                entry.name,
                f"{_apart(own, clip):.4f}",
                f"{_apart(evaluator.clip(Splice(entry.name, entry.name)), clip):.3f}",
                _percentiles((pairwise - frames[: len(pairwise)]) * working),
                _percentiles(_slip(small, uneven.name, clip.name, frames) * working),
                f"{_apart(*exact):.1e}",
                f"{_apart(*splice):.4f}",
                _seam(bank, entry),
            )
    Console(width=150).print(table)


def _bank(folder: Path, like: Bank, baseline: Clip, *clips: Clip) -> Bank:
    """Writes and opens a bank of clips with the roles of the bank `like`. Each clip is its own neutral."""
    ring, rig = find_baseline(baseline, like.roles), Rig(baseline.skeleton, like.roles)
    names = {clip.name: clip for clip in (baseline, *clips)}
    prepared = [prepare(clip, like.roles, rig, ring) for clip in names.values()]
    settled = [replace(one, neutral=one.name) for one in prepared]
    write_bank(folder, rig, ring, {one.name: one for one in settled})
    return Bank.open(folder)


def _slip(bank: Bank, uneven: str, even: str, frames: Floats) -> Floats:
    """Returns how far each phase of the uneven copy is from the phase of its source frame, in frames of the clip.

    Whole cycles do not count: when a person turns on the spot, an alignment may have a cycle more or less.
    """
    phases = [bank.phase(name) for name in (uneven, even)]
    numbers = np.arange(len(phases[1]))
    apart = phases[0] - np.interp(frames, numbers, phases[1])
    return (apart - np.round(apart)) / np.interp(frames, numbers, np.gradient(phases[1]))


def _seam(bank: Bank, entry: ClipEntry) -> str:
    """Returns the largest acceleration in the seam, divided by the 99th percentile of the clip's accelerations."""
    if entry.loop == 0:
        return ""
    whole = accelerations(bank.motion(entry.name, seam=True))
    own = len(accelerations(bank.motion(entry.name)))
    return f"{whole[own - 1 :].max() / np.percentile(whole[:own], 99):.2f}"


def _apart(a: Clip, b: Clip) -> float:
    """Returns the largest distance between the joints of two clips, in millimetres."""
    frames = min(a.frame_count, b.frame_count)
    apart = joint_positions(a.frames(0, frames)) - joint_positions(b.frames(0, frames))
    return 1000.0 * float(np.linalg.norm(apart, axis=-1).max())


def _percentiles(error: Floats) -> str:
    return "{:.2f} / {:.2f}".format(*np.percentile(np.abs(error), [50, 95]))


if __name__ == "__main__":
    run(lambda: typer.run(main))
