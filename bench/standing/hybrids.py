"""Measures hybrid actions, which stand and walk by turns, against generated truth: `python -m bench.standing.hybrids`.

A person stands and performs a gesture, then walks and carries a box, or the other way round. The hybrid is laid on
each built-in locomotion, and each of its stretches compared with the person of that locomotion who does the same: mean
error of the upper body's joints, centimetres, with the hips at the origin, without the second after each handover, and
without the half second before a stop.

Methods: `alone` is the same stretch captured as a clip of its own, `hybrid` the evaluator's splice of the hybrid,
`replaced` plain replacement and `additive` what game engines offer.
"""

from __future__ import annotations

import tempfile
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
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
from motionsplice.motion.procedural.joined import begins as begins_of
from motionsplice.motion.procedural.joined import joined
from motionsplice.motion.procedural.library import LOCOMOTIONS, make
from motionsplice.motion.procedural.stances import STANDING, fair, standing_action, standing_truth
from motionsplice.motion.quaternion import Floats
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice

SETTLED = 1.0  # seconds after a handover that do not count
SECONDS = 14.0  # of the locomotions
WALKED = ("carry_box", "carry_cup", "plain")  # of the walking stretch; `plain` only walks
STOPPING = 0.5  # seconds before a handover in which a walking person stops
FRAME = 1.0 / 60.0


def main(seeds: Annotated[int, typer.Option(min=1, help="Number of persons")] = 2) -> None:
    """Prints one table for each person."""
    console = Console(width=110)
    for seed in range(1, seeds + 1):
        with tempfile.TemporaryDirectory() as folder:
            console.print(table(Person(Path(folder), seed)))


def table(person: Person) -> Table:
    """Returns the mean error of each method in standing and in walking stretches, over all locomotions."""
    errors: defaultdict[str, list[Mapping[str, float]]] = defaultdict(list)
    for locomotion in LOCOMOTIONS:
        for stand, walk in person.pairs:
            for order in ((stand, walk), (walk, stand)):
                for name, found in person.errors(locomotion, order).items():
                    place = "first" if name == order[0] else "then"
                    errors[f"{'stands' if name == stand else 'walks'}, {place}"].append(found)
    methods = ("alone", "hybrid", "replaced", "additive")
    shown = Table(title=f"person {person.seed}: error, cm", title_justify="left")
    for column in ("", *methods, "hybrid / alone"):
        shown.add_column(column, justify="right" if column else "left")
    for label, of_label in sorted(errors.items()):
        means = [float(np.mean([one[how] for one in of_label])) for how in methods]
        shown.add_row(label, *(f"{mean:.2f}" for mean in means), f"{means[1] / means[0]:.2f}")
    return shown


class Person:
    """A person's clips: locomotions, gestures captured standing and actions captured walking, and hybrids of both."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.seed = seed
        self.performers = {name: fair(10 * seed + number) for number, name in enumerate(STANDING)}
        self.pairs = [(name, WALKED[number % len(WALKED)]) for number, name in enumerate(STANDING)]
        self.parts = {name: standing_action(name, one, seed=seed) for name, one in self.performers.items()}
        self.parts |= {name: make("walk", _action(name), seed=seed) for name in WALKED}
        orders = [order for pair in self.pairs for order in (pair, pair[::-1])]
        actions = self.parts | {"-".join(one): joined("-".join(one), [self.parts[a] for a in one]) for one in orders}
        walks = {name: make(name, seed=self._seed(name), seconds=SECONDS) for name in LOCOMOTIONS}
        clips = folder / "clips"
        clips.mkdir()
        for name, clip in (walks | actions).items():
            (clips / f"{name}.bvh").write_bytes(dump_bvh(clip))
        (clips / "clips.toml").write_text("\n".join(f'["{name}"]\nkind = "action"' for name in actions))
        build_bank([clips], folder / "bank", baseline="walk")
        self.alone, self.truth = cache(self._alone), cache(self._truth)
        self.evaluator = Evaluator(Bank.open(folder / "bank"))

    def errors(self, locomotion: str, order: tuple[str, str]) -> dict[str, dict[str, float]]:
        """Returns the mean error of each method, centimetres, by the name of the stretch."""
        bank, hybrid = self.evaluator.bank, "-".join(order)
        clip_l, seconds = bank.motion(locomotion), bank.clip(hybrid).duration
        replaced = self.evaluator.clip(Splice(locomotion, hybrid, method="naive"))
        times = self.evaluator.frame_times(locomotion)
        played = self.evaluator.action_frames(Splice(locomotion, hybrid), times) * FRAME
        clips = {
            "hybrid": (self.evaluator.clip(Splice(locomotion, hybrid)), played),
            "replaced": (replaced, times),
            "additive": (add(clip_l, replaced, bank.roles), times),
        }
        _, then = bank.clip(hybrid).stretches
        handover = bank.begin_of(then)
        begins = dict(zip(order, begins_of([self.parts[name] for name in order]), strict=True))
        found: dict[str, dict[str, float]] = {}
        for name, (begin, end) in zip(order, ((0.0, handover), (handover, seconds)), strict=True):
            settled = SETTLED if begin else 0.0
            end -= STOPPING if name in WALKED and begin == 0.0 else 0.0
            found[name] = {}
            for how, (clip, at) in clips.items():
                within = np.flatnonzero((at >= begin) & (at < end))
                once = within[: 1 + int(np.argmax(np.append(np.diff(at[within]), -1.0) < 0.0))]  # not its repetition
                counted = once[times[once] >= times[once[0]] + settled]
                delay = 0.0 if name in WALKED else float((times - at)[within[0]]) + begins[name]
                truth = self.truth(locomotion, name, round(delay, 4))
                found[name][how] = 100.0 * float(upper_body_errors(clip, truth, bank.roles)[counted].mean())
                if how == "hybrid":
                    frames = np.round((times[counted] - delay) / FRAME).astype(np.int64)
                    alone = self.alone(locomotion, name)[frames]
                    found[name]["alone"] = float(alone.mean())
        return found

    def _alone(self, locomotion: str, name: str) -> Floats:
        clip = self.evaluator.clip(Splice(locomotion, name))
        errors = upper_body_errors(clip, self.truth(locomotion, name, 0.0), self.evaluator.bank.roles)
        return np.asarray(100.0 * errors.mean(axis=1))

    def _truth(self, locomotion: str, name: str, delay: float) -> Clip:
        """Returns the person of a locomotion who performs an action; a gesture `delay` seconds later."""
        seed = self._seed(locomotion)
        if name in WALKED:
            return make(locomotion, _action(name), seed=seed, seconds=SECONDS)
        performer = self.performers[name]
        later = replace(performer, delay=performer.delay + delay)
        return standing_truth(locomotion, name, later, locomotion_seed=seed, seed=self.seed, seconds=SECONDS)

    def _seed(self, locomotion: str) -> int:
        return 20 * self.seed + LOCOMOTIONS.index(locomotion)


def _action(name: str) -> str | None:
    return None if name == "plain" else name


if __name__ == "__main__":
    run(lambda: typer.run(main))
