"""The report of a bank that `motionsplice precompute` and `inspect` print: tables, and remarks on the clips."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from motionsplice.motion.errors import MotionError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.entries import ClipEntry

NAMES = 6  # clips that a line about many of them names
STEADY = (0.67, 1.5)  # paces of a phase, relative to its mean, that need no mention

console = Console(emoji=False)


def show_tables(bank: Bank) -> None:
    """Prints a bank's clips and hands as tables, and the job's warnings."""
    stride, count = bank.baseline.end - bank.baseline.start, len(bank.clips)
    console.print(
        f"{bank.path}: {count} clip{'s' * (count != 1)}, {bank.skeleton.joint_count} joints, "
        f"baseline {bank.baseline.clip!r} (a stride of {stride:.2f} s from {bank.baseline.start:.2f} s)",
        highlight=False,
        soft_wrap=True,
    )
    console.print(clips_table(bank))
    if bank.hands:
        console.print(hands_table(bank))
    clips = [(clip.name, sentence) for clip in bank.clips for sentence in clip.warnings]
    hands = [(one.name, sentence) for one in bank.hands for sentence in one.warnings]
    print_grouped("yellow", [*clips, *hands], [clip.name for clip in bank.clips])


def notes_of(bank: Bank) -> list[tuple[str, str]]:
    """Returns the names of clips, each with a note on it."""
    return [(clip.name, sentence) for clip in bank.clips for sentence in clip.notes]


def uneven_clips(bank: Bank) -> list[tuple[str, str]]:
    """Returns the names of clips whose strides are uneven, each with a sentence on the range of its phase's pace."""
    found = []
    for clip in bank.clips:
        if clip.gait and not clip.stretches:
            steps = np.diff(bank.phase(clip.name))
            low, high = steps.min() / steps.mean(), steps.max() / steps.mean()
            if low < STEADY[0] or high > STEADY[1]:
                said = f"its phase runs at {low:.1f} to {high:.1f} times its mean pace, so splices hurry and wait"
                found.append((clip.name, said))
    return found


def reasons_of(failed: Mapping[str, MotionError]) -> list[tuple[str, str]]:
    """Returns the names of clips that failed, each with the reason. Those that fail alike in several files share one,
    which names the first file and counts the others."""
    alike: dict[str, dict[str, list[str]]] = {}
    for name, error in failed.items():
        alike.setdefault(str(error.of_file("")), {}).setdefault(error.file, []).append(name)
    found = []
    for files in alike.values():
        (first, named), rest = next(iter(files.items())), len(files) - 1
        label = f"{first} and {rest} more file{'s' * (rest > 1)}" if rest else first
        found += [(name, str(failed[named[0]].of_file(label))) for names in files.values() for name in names]
    return found


def print_grouped(
    style: str, about: Iterable[tuple[str, object]], clips: Iterable[str], verb: str = "", to: Console = console
) -> None:
    """Prints sentences about clips, each once, after the names of all clips that it is about.

    clips: the names of all clips, for `moves:*` to stand for all of a file's.
    """
    per_file = Counter(clip.partition(":")[0] for clip in clips)
    names: dict[str, list[str]] = {}
    for name, sentence in about:
        names.setdefault(str(sentence), []).append(name)
    for sentence, named in names.items():
        line = f"[{style}]{escape(_in_short(named, per_file))}{verb}: {escape(sentence)}[/{style}]"
        to.print(line, highlight=False, soft_wrap=True)


def _in_short(names: list[str], per_file: Counter[str]) -> str:
    """Returns names as text: `moves:*` for all clips of a file with several, and at most NAMES of them."""
    here = Counter(name.partition(":")[0] for name in names)
    whole = {file for file, count in here.items() if count == per_file[file] > 1}
    files = ((name, name.partition(":")[0]) for name in names)
    short = list(dict.fromkeys(f"{file}:*" if file in whole else name for name, file in files))
    rest = len(short) - NAMES
    return ", ".join(short[:NAMES]) + (f" and {rest} more" if rest > 0 else "")


def clips_table(bank: Bank) -> Table:
    """Returns a table of the clips, and of how well each is aligned. Neutrals are left out if no clip is an action."""
    actions = any(clip.kind == "action" for clip in bank.clips)
    caption = "mean, worst: distance of root and knees from the baseline's at the same phase, cm"
    of_actions = (
        "; torso: motion of an action's shoulders beyond its neutral's gait, degrees; repeat: distance of its upper "
        "body from itself a stride later, cm"
    )
    table = Table(caption=caption + of_actions * actions)
    for column in ("clip", "neutral")[: 1 + actions]:
        table.add_column(column, overflow="fold")
    for column in ("s", "rate", "cycles", "mean", "worst", "torso", "repeat")[: 5 + 2 * actions]:
        table.add_column(column, justify="right", no_wrap=True)
    for clip in bank.clips:
        mean = "" if clip.stands else f"{100 * clip.mean_mismatch:.1f}"  # its phase has no meaning
        action = clip.kind == "action"
        cells = [
            " ".join((escape(clip.name), *(f"[cyan]#{escape(tag)}[/cyan]" for tag in clip.tags))),
            _neutral(bank, clip) if action else "",
            f"{clip.duration:.2f}",
            f"{clip.rate:.5g}",
            "" if clip.stands else f"{clip.cycles:.2f}",
            f"[yellow]{mean}[/yellow]" if clip.warnings else mean,
            "" if clip.stands else f"{100 * clip.worst_mismatch:.1f}",
            f"{np.degrees(clip.shoulder_motion):.1f}" if action else "",
            f"{100 * clip.repetition:.1f}" if action and clip.repetition > 0.0 else "",
        ]
        table.add_row(*cells if actions else (cells[0], *cells[2:-2]))
    return table


def _neutral(bank: Bank, clip: ClipEntry) -> str:
    neutral = bank.neutral(clip.name)
    return "itself" if clip.stands and neutral == clip.name else escape(neutral)


def hands_table(bank: Bank) -> Table:
    """Returns a table of the hands on each clip, and of how far their time runs from the body's."""
    table = Table(
        caption="mismatch: mean phase cost of aligned frames over that of all frames in the band, 0 for identical "
        "gestures and about 1 for unrelated ones; ahead: seconds by which the hands run ahead of the body, least and "
        "most"
    )
    for column in ("hands", "on", "hand", "wrist", "pairs"):
        table.add_column(column, overflow="fold")
    for column in ("mismatch", "ahead"):
        table.add_column(column, justify="right", no_wrap=True)
    for one in bank.hands:
        frames, rate = bank.hand_frames(one.name, one.body), bank.clip(one.body).rate
        sides = {"left": [0], "right": [1]}.get(one.hand, [0, 1])
        ahead = frames[:, sides] / one.rate - np.arange(len(frames))[:, None] / rate
        table.add_row(
            escape(one.name),
            escape(one.body),
            one.hand,
            "yes" if one.wrist else "",
            " ".join(one.pairs),
            f"[yellow]{one.mismatch:.2f}[/yellow]" if one.warnings else f"{one.mismatch:.2f}",
            f"{ahead.min():.2f} to {ahead.max():.2f}",
        )
    return table
