"""Measures retargeting: `python -m bench.retarget [FILES]`.

Built-in motions stand on rigs like those of Mixamo, Rigify, VRM, Unreal, CMU and LAFAN1, and are carried from each to
each. FILES are motion files whose rigs join them, without a truth.

limbs      largest angle between directions of the eight limb bones, degrees
roll       largest error of a limb's rotation, about its own length too, against the truth on that rig, degrees
feet       the same of the feet: 0 if they are as flat as in the truth
hands      the same of the hands
trunk, shoulders  largest angle between the lines from hips to shoulders, and from shoulder to shoulder, degrees. Other
           proportions have other lines.
ankles     largest distance of an ankle from its place in the original, percent of a leg
slide      mean speed of standing ankles over the floor, percent of a leg per second: in the original and here
back       largest angle of a limb bone after the way there and back, degrees
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.retarget import measures
from bench.retarget.kinds import KINDS
from bench.retarget.measures import Posed
from bench.retarget.rigs import on_rig
from motionsplice.cli import run
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.files import clips_in
from motionsplice.motion.formats.reading import Reading, read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.retarget.by_roles import retarget
from motionsplice.motion.retarget.stance import standing_pose
from motionsplice.motion.roles import find_roles

COLUMNS = ("limbs", "roll", "feet", "hands", "trunk", "shoulders", "ankles", "slide", "back", "ms")


def main(
    files: Annotated[list[Path] | None, typer.Argument(help="Motion files of other rigs.")] = None,
    motion: Annotated[str, typer.Option(help="The built-in locomotion.")] = "walk",
    action: Annotated[str, typer.Option(help="The built-in action on it.")] = "wave",
) -> None:
    """Prints what is kept of a motion from each rig to each."""
    built = [(name, _posed(on_rig(make(motion, action), kind))) for name, kind in KINDS.items()]
    read = [(name, Posed.of(found.clip, found.roles)) for name, found in _readings(files or [])]
    table = Table(title=f"{motion} + {action}", title_justify="left")
    for column in ("from", "to", *COLUMNS):
        table.add_column(column, justify="left" if column in ("from", "to") else "right", no_wrap=True)
    for name, theirs in [*built, *read]:
        for other, ours in [*built, *read]:
            if name != other:
                truth = ours if (name, theirs) in built and (other, ours) in built else None
                table.add_row(name, other, *_row(theirs, ours, truth))
        table.add_section()
    Console(width=150).print(table)


def _readings(files: Sequence[Path]) -> Iterator[tuple[str, Reading]]:
    for file in files:
        name, animation = next(iter(clips_in(file).items()))
        yield name, read_clip(file, animation=animation)


def _posed(clip: Clip) -> Posed:
    return Posed.of(clip, find_roles(clip.skeleton))


def _row(theirs: Posed, ours: Posed, truth: Posed | None) -> list[str]:
    pose = standing_pose(ours.clip.skeleton, ours.roles, ours.clip)
    start = time.perf_counter()
    got = Posed.of(retarget(theirs.clip, theirs.roles, ours.clip.skeleton, ours.roles, pose).clip, ours.roles)
    seconds = time.perf_counter() - start
    back = retarget(
        got.clip,
        got.roles,
        theirs.clip.skeleton,
        theirs.roles,
        standing_pose(theirs.clip.skeleton, theirs.roles, theirs.clip),
    ).clip
    against = [
        "" if truth is None else f"{measures.turn_errors(got, truth, parts):.1f}"
        for parts in (("thigh", "shin", "arm"), ("foot",), ("hand",))
    ]
    return [
        f"{measures.limbs(theirs, got):.3f}",
        *against,
        f"{measures.trunk(theirs, got):.1f}",
        f"{measures.shoulder_line(theirs, got):.1f}",
        f"{measures.ankles(theirs, got):.1f}",
        f"{measures.slide(theirs):.1f} {measures.slide(got):.1f}",
        f"{measures.limbs(theirs, Posed.of(back, theirs.roles)):.3f}",
        f"{1000.0 * seconds:.0f}",
    ]


if __name__ == "__main__":
    run(lambda: typer.run(main))
