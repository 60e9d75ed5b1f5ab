"""Compares the two postures at run time (Heck's thesis, 4.3): `python -m bench.quality.postures [CLIPS]`.

Posture `absolute` uses the stored mean postures, and `running` a running mean of the splice's own posture. Both are
compared with the papers' exact transfer, which uses the whole clip. Without CLIPS, the motions are built-in ones of a
minute whose lean drifts slowly; with CLIPS, the pairs of a CSV file.
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
from bench.quality.measures import neck_jitter, posture_error
from bench.quality.pair_list import PAIRS, read_pairs
from motionsplice.cli import run
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.splice import transfer_posture
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Memory
from motionsplice.runtime.splice import Splice

TIME_CONSTANTS = (0.5, 1.0, 2.0, 4.0, 8.0)  # seconds
DRIFTS = {"walk": (8.0, 40.0), "carry_box": (8.0, 25.0)}  # amplitude of the lean in degrees, period in seconds


def main(
    clips: Annotated[
        Path | None, typer.Argument(help="Folder of clips; default: built-in motions with a drifting lean")
    ] = None,
    pairs: Annotated[Path, typer.Option(help="CSV file of pairs, used with CLIPS")] = PAIRS,
) -> None:
    """Prints one row per pair and method."""
    table = Table(
        title="Postures at run time compared with the exact transfer",
        caption="posture °: angle between the mean postures of the result and the action",
    )
    for column in ("locomotion <- action", "method", "from exact °, rms", "worst °", "posture °", "jitter / exact"):
        table.add_column(column, justify="right" if table.columns else "left")
    with tempfile.TemporaryDirectory() as folder:
        bank = bank_of(clips, None, Path(folder)) if clips else drifting_bank(Path(folder))
        evaluator, roles = Evaluator(bank), bank.roles
        chosen = [(one.locomotion, one.action) for one in read_pairs(pairs)] if clips else [("walk", "carry_box")]
        for locomotion, action in chosen:
            plain, target = evaluator.clip(Splice(locomotion, action, posture="off")), bank.motion(action)
            torso = measure_torso(plain, roles)
            exact = transfer_posture(
                plain, torso, horn_rotation(measure_torso(target, roles).posture, torso.posture), roles
            )
            results = {"stored": evaluator.clip(Splice(locomotion, action, posture="absolute"))}
            results |= {
                f"running, {c:g} s": with_running_mean(evaluator, locomotion, action, c) for c in TIME_CONSTANTS
            }
            for method, clip in results.items():
                apart = np.degrees(quaternion.angle(clip.rotations[:, roles.pelvis], exact.rotations[:, roles.pelvis]))
                numbers = [np.sqrt(np.mean(apart**2)), apart.max(), np.degrees(posture_error(clip, target, roles))]
                numbers.append(neck_jitter(clip, roles) / neck_jitter(exact, roles))
                table.add_row(f"{locomotion} <- {action}", method, *(f"{number:.2f}" for number in numbers))
            table.add_section()
    Console(width=120).print(table)


def with_running_mean(evaluator: Evaluator, locomotion: str, action: str, time_constant: float) -> Clip:
    """Evaluates a whole splice with posture `running` and a time constant in seconds."""
    plain = evaluator.clip(Splice(locomotion, action, posture="off"))
    memory = Memory.begin(1, plain.rate, time_constant)
    times = evaluator.frame_times(locomotion)
    poses = evaluator.sequence(Splice(locomotion, action, posture="running"), times, memory=memory)
    return replace(plain, rotations=poses.rotations.astype(np.float64))


def drifting_bank(folder: Path) -> Bank:
    """Builds a bank of a walk and of a walk with a box, a minute each, that slowly lean forward and back."""
    clips = folder / "clips"
    clips.mkdir()
    for name, (degrees, seconds) in DRIFTS.items():
        clip = make("walk", None if name == "walk" else name, seconds=60.0, seed=3)
        lean = np.radians(degrees) * np.sin(2.0 * np.pi * np.arange(clip.frame_count) / clip.rate / seconds)
        pelvis, rotations = find_roles(clip.skeleton).pelvis, clip.rotations.copy()
        rotations[:, pelvis] = quaternion.multiply(quaternion.about([1.0, 0.0, 0.0], lean), rotations[:, pelvis])
        (clips / f"{name}.bvh").write_bytes(dump_bvh(replace(clip, rotations=rotations)))
    (clips / "clips.toml").write_text('[carry_box]\nkind = "action"\nneutral = "walk"\n')
    build_bank([clips], folder / "bank", baseline="walk")
    return Bank.open(folder / "bank")


if __name__ == "__main__":
    run(lambda: typer.run(main))
