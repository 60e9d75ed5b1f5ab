"""`motionsplice study`: which upper-body motions correlate with the legs, and which of them survive a splice."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from motionsplice.commands.reading_options import Rate, RolesFile, Root, SkipFrames, Unit, Up
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.roles import read_roles_file
from motionsplice.pictures.correlation_charts import draw_chart
from motionsplice.precompute.study.body_angles import View
from motionsplice.precompute.study.correlation import (
    Correlation,
    Key,
    Study,
    Survival,
    Verdict,
    lag_between,
    study,
    survival,
)
from motionsplice.precompute.study.periodic import Period

console = Console(emoji=False)

CAPTION = (
    "global: relative to the direction of travel; local: relative to the parent joint; degrees: amplitude; "
    "lag: degrees of the stride or step from the moment a thigh is foremost (in a stride, the left one) to the "
    "joint's peak"
)
COLOURS = {Survival.KEPT: "green", Survival.CHANGED: "yellow", Survival.LOST: "red"}


def register(app: typer.Typer) -> None:
    app.command("study", epilog="Example: [bold]motionsplice study truth.bvh splice.bvh --out study[/bold]")(
        study_command
    )


def study_command(
    motions: Annotated[list[Path], typer.Argument(help="Motion files; each is compared with the first.")],
    out: Annotated[Path | None, typer.Option(help="A folder for study.json and two plots of each motion.")] = None,
    skip_frames: SkipFrames = 0,
    unit: Unit = None,
    up: Up = None,
    rate: Rate = None,
    root: Root = None,
    roles: RolesFile = None,
) -> None:
    """Find which upper-body motions correlate with the legs, and which of them other motions keep."""
    given = read_roles_file(roles) if roles else {}
    read = partial(read_clip, skip_frames=skip_frames, unit=unit, up=up, rate=rate, root=root, roles=given)
    readings = [read(file) for file in motions]
    names = [reading.clip.name for reading in readings]
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise SettingsError(f"two motions are named {twice[0]!r}", mend="Rename one of the files")
    studies = [study(reading.clip, reading.roles) for reading in readings]
    console.print(findings(studies))
    for line in summary(studies):
        console.print(line, highlight=False, soft_wrap=True)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        for one in studies:
            for view in View:
                draw_chart(one, view, out / f"{one.name}-{view}.png")
        (out / "study.json").write_text(json.dumps([report(one, studies[0]) for one in studies], indent=1) + "\n")
        console.print(f"{out}: {2 * len(studies)} plots and study.json")


def findings(studies: Sequence[Study]) -> Table:
    """Returns a table with a row for each correlation of the first motion, and a column for each other motion."""
    first, *others = studies
    table = Table(caption=CAPTION)
    for column in ("joint", "about"):
        table.add_column(column, no_wrap=True)
    for column in ("degrees", "strength", "lag"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column(escape(first.name), no_wrap=True)
    for other in others:
        table.add_column(escape(other.name), no_wrap=True)
    group: tuple[View, Period] | None = None
    for key, one in first.found.items():
        if group != (key.view, key.period):
            group = key.view, key.period
            table.add_section()
            table.add_row(f"[bold]{key.view}, each {key.period.name.lower()}[/bold]")
        numbers = (f"{np.degrees(one.amplitude):.1f}", f"{one.strength:.2f}", f"{np.degrees(one.lag):.0f}")
        table.add_row(key.joint, key.axis, *numbers, one.verdict, *(_fate(one, other) for other in others))
    return table


def summary(studies: Sequence[Study]) -> list[str]:
    """Returns a line for each motion."""
    first, *others = studies
    moving = sum(one.verdict is not Verdict.STILL for one in first.correlations)
    strides = first.phase[-1] - first.phase[0]
    lines = [f"{escape(first.name)}: {len(first.found)} correlations in {moving} moving curves, {strides:.1f} strides"]
    for other in others:
        fates = Counter(survival(one, other) for one in first.found.values())
        known = sum(fates[fate] for fate in Survival)
        rest = ", ".join(f"{fates[fate]} {fate}" for fate in (Survival.CHANGED, Survival.LOST))
        lines.append(f"{escape(other.name)}: {fates[Survival.KEPT]} of {known} correlations kept, {rest}")
    return lines


def report(one: Study, first: Study) -> dict[str, Any]:
    """Returns a motion's entry in study.json."""
    return {
        "name": one.name,
        "seconds": round(float(one.seconds[-1]), 4),
        "strides": round(float(one.phase[-1] - one.phase[0]), 4),
        "correlations": [_numbers(item, first.found) for item in one.correlations],
    }


def _numbers(one: Correlation, first: dict[Key, Correlation]) -> dict[str, Any]:
    ours = first.get(one.key)
    return {
        "view": one.curve.view,
        "joint": one.curve.joint,
        "axis": one.curve.axis,
        "period": one.period.name.lower(),
        "amplitude_degrees": round(float(np.degrees(one.amplitude)), 3),
        "strength": round(one.strength, 4),
        "lag_degrees": round(float(np.degrees(one.lag)), 2),
        "p": round(one.p, 5),
        "verdict": one.verdict,
        "lag_from_first_degrees": round(float(np.degrees(lag_between(ours, one))), 2) if ours else None,
    }


def _fate(one: Correlation, other: Study) -> str:
    """Returns whether another motion keeps a correlation, and by how many degrees its lag changed."""
    fate = survival(one, other)
    if fate is None:
        return "no such joint"
    moved = "" if fate is Survival.LOST else f" {np.degrees(lag_between(one, other.found[one.key])):+.0f}°"
    return f"[{COLOURS[fate]}]{fate}{moved}[/{COLOURS[fate]}]"
