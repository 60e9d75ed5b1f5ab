"""Damaged banks that are opened without verification: `python -m tests.hardening.damaged_banks [--flips 10000]`.

A number of a table is damaged in each step: a bit is flipped, or another number written. The bank is then evaluated:
all pairs of clips by all methods, characters with actions, hands, aims and locked feet, and the functions of a bank.
Tables lie between guarded pages, so that reading outside one ends the process with a signal. Only typed errors may be
raised. With NUMBA_DISABLE_JIT=1, kernels are plain Python, which checks every index; that takes a second for each step.
"""

from __future__ import annotations

import faulthandler
import warnings
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from motionsplice.cli import run
from motionsplice.motion.errors import MotionError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import Aim, Look
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.format.checks import check_fit, check_references
from motionsplice.runtime.stage import Stage
from tests.hardening.fuzz.banks import evaluated, played_bank, small_bank
from tests.hardening.guarded import guarded

RATE = 60.0
STEPS = (1, 1, 7, 100_000)  # frames by which characters advance
NUMBERS = (0.0, -1.0, np.nan, np.inf, -np.inf, 1e9, -1e9, 1e38, 1e-45, 2.0**31, 255.0, 0.5)


def damage(table: NDArray[Any], draw: np.random.Generator) -> None:
    """Damages a number of a table."""
    flat = table.reshape(-1)
    at = int(draw.integers(len(flat)))
    if draw.random() < 0.5:
        data = flat[at : at + 1].view(np.uint8)
        data[draw.integers(len(data))] ^= 1 << int(draw.integers(8))
    else:
        with np.errstate(invalid="ignore", over="ignore"):
            flat[at] = np.asarray(draw.choice(NUMBERS)).astype(table.dtype)


def use(bank: Bank, *, plays: bool) -> None:
    """Evaluates a bank in every way, as if it had been damaged after it was opened, and then as if before.

    plays: whether its rig is a body, which characters need. Raises MotionError.
    """
    evaluated(bank)
    if plays:
        play(Stage(Evaluator(bank)))
    check_fit(bank.manifest, bank.tables, "")
    check_references(bank.manifest, bank.tables, bank.files)
    for clip in bank.numbered:
        bank.motion(clip.name)
        bank.contacts(clip.name)
        bank.phase(clip.name)
        bank.neutral(clip.name)


def play(stage: Stage) -> None:
    """Plays characters that use all that a bank has."""
    names, characters = [clip.name for clip in stage.bank.numbered], Characters(stage, RATE)
    characters.add(len(names), {names[0]: 0.5, names[1]: 0.5})
    rows = list(range(len(names)))
    for row, name in enumerate(names):
        characters.play([row], name, blend=0.1)
        characters.act([row], Action(name, blend=0.05, posture="running"))
        characters.act([row], Action(names[0], mask="arms", weight=0.5))
    characters.lock_feet(rows, True)
    characters.look(rows, Look([1.0, 1.0, 3.0]))
    characters.aim(rows, Aim([1.0, 1.0, 3.0], part="right_arm"))
    for frames in STEPS:
        characters.evaluate(stage.evaluator.poses(len(names)))
        characters.advance(frames)


def check(flips: int, seed: int) -> Counter[str]:
    """Damages banks `flips` times, and uses each. Returns the outcomes. Raises what is no typed error."""
    draw, outcomes = np.random.default_rng(seed), Counter[str]()
    banks = [Bank(one.path, one.manifest, {name: guarded(table) for name, table in one.tables.items()})
             for one in (small_bank(), played_bank())]  # fmt: skip
    for _ in range(flips):
        number = int(draw.integers(len(banks)))
        name = str(draw.choice([name for name, table in banks[number].tables.items() if table.size]))
        table = banks[number].tables[name]
        sound = table.copy()
        damage(table, draw)
        try:
            with warnings.catch_warnings(action="ignore"):
                use(Bank(Path(), banks[number].manifest, banks[number].tables), plays=number == 1)
            outcomes["used"] += 1
        except MotionError as error:
            outcomes[f"refused by {type(error).__name__}"] += 1
        table[...] = sound
    return outcomes


def main(
    flips: Annotated[int, typer.Option(min=1, help="Number of damages")] = 10_000,
    seed: Annotated[int, typer.Option(help="Number from which damages are drawn")] = 0,
) -> None:
    """Prints how many damaged banks were used, and how many refused."""
    faulthandler.enable()
    outcomes = check(flips, seed)
    print(f"{flips} damages: {', '.join(f'{count} {what}' for what, count in sorted(outcomes.items()))}")


if __name__ == "__main__":
    run(lambda: typer.run(main))
