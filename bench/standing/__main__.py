"""Measures standing actions against generated truth: `python -m bench.standing`.

Each built-in standing action is laid on each built-in locomotion, and compared with the person of that locomotion who
performs the action: mean position error of the upper body's joints, centimetres, with the hips at the origin.

The performer who flatters repeats the gesture exactly. The fair one has another timing and size, keeps hands and gaze
steadier than the chest, and turns the hips with the chest while standing (`motion/procedural/stances.py`).
Methods: `replaced` is plain replacement; `additive` what game engines offer; `offline` is `splice_standing`; `bank` the
evaluator's splice.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from bench.quality.additive import add
from bench.quality.measures import upper_body_errors
from motionsplice.cli import run
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import LOCOMOTIONS, make
from motionsplice.motion.procedural.stances import (
    BEGIN,
    END,
    SECONDS,
    STANDING,
    Performer,
    fair,
    standing_action,
    standing_truth,
)
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.splice import splice_standing
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice


def main(seeds: Annotated[int, typer.Option(min=1, help="Number of persons for each performer")] = 2) -> None:
    """Prints one table for each performer and seed."""
    console = Console(width=110)
    for title in ("flattering", "fair"):
        for seed in range(1, seeds + 1):
            console.print(table(f"{title} performer, person {seed}: error, cm", title == "fair", seed))


def table(title: str, is_fair: bool, seed: int) -> Table:
    """Returns the mean error of each method, by action and over all, and over all within the gestures."""
    performers = {name: fair(10 * seed + number) if is_fair else Performer() for number, name in enumerate(STANDING)}
    with tempfile.TemporaryDirectory() as folder:
        errors = errors_of(Evaluator(standing_bank(Path(folder), performers, seed)), performers, seed)
    methods = list(next(iter(errors.values())))
    found = Table(title=title, title_justify="left")
    for column in ("", *methods):
        found.add_column(column, justify="right" if column else "left")
    for action in STANDING:
        of_action = [one for (_, name), one in errors.items() if name == action]
        found.add_row(action, *(f"{np.mean([one[how] for one in of_action]):.2f}" for how in methods))
    found.add_section()
    first, last = (round(60.0 * seconds) for seconds in (BEGIN, END))
    for label, within in (("all", slice(None)), ("all, during the gesture", slice(first, last))):
        means = (np.mean([one[how][within] for one in errors.values()]) for how in methods)
        found.add_row(label, *(f"{mean:.2f}" for mean in means))
    return found


def standing_bank(folder: Path, performers: Mapping[str, Performer], seed: int) -> Bank:
    """Builds a bank of all locomotions, and of all standing actions by these performers."""
    clips = folder / "clips"
    clips.mkdir()
    made = {name: make(name, seed=_seed(name, seed)) for name in LOCOMOTIONS}
    made |= {name: standing_action(name, performer, seed=seed) for name, performer in performers.items()}
    for name, clip in made.items():
        (clips / f"{name}.bvh").write_bytes(dump_bvh(clip))
    (clips / "clips.toml").write_text("\n".join(f'[{name}]\nkind = "action"' for name in performers))
    build_bank([clips], folder / "bank", baseline="walk")
    return Bank.open(folder / "bank")


def errors_of(
    evaluator: Evaluator, performers: Mapping[str, Performer], seed: int
) -> dict[tuple[str, str], dict[str, np.ndarray]]:
    """Returns the error [F] of each method, centimetres, by locomotion and action."""
    bank, errors = evaluator.bank, {}
    for locomotion in LOCOMOTIONS:
        for action, performer in performers.items():
            truth = standing_truth(locomotion, action, performer, locomotion_seed=_seed(locomotion, seed), seed=seed)
            clips, standing = (bank.motion(locomotion), bank.motion(action)), bank.standing(action)
            assert standing is not None
            replaced = evaluator.clip(Splice(locomotion, action, method="naive"))
            results: dict[str, Clip] = {
                "replaced": replaced,
                "additive": add(clips[0], replaced, bank.roles),
                "offline": splice_standing(*clips, bank.roles, standing),
                "bank": evaluator.clip(Splice(locomotion, action)),
            }
            frames = round(SECONDS * truth.rate) + 1
            errors[locomotion, action] = {
                how: 100.0 * upper_body_errors(clip, truth.frames(0, frames), bank.roles).mean(axis=1)
                for how, clip in results.items()
            }
    return errors


def _seed(locomotion: str, seed: int) -> int:
    return 20 * seed + LOCOMOTIONS.index(locomotion)


if __name__ == "__main__":
    run(lambda: typer.run(main))
