"""The pairs to judge and their truths: from a CSV file, or every built-in action on every built-in locomotion."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from bench.quality.aligned_truth import aligned_truth
from bench.quality.claims import CLAIMS
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError, did_you_mean
from motionsplice.motion.procedural.library import ACTIONS, LOCOMOTIONS, truth
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import find_roles
from motionsplice.runtime.bank import Bank

PAIRS, EXAMPLES = (Path(__file__).with_name(name) for name in ("pairs.csv", "examples.csv"))
MOST_PAIRS = 400  # of a bank that are judged without a list; each takes about a second
COLUMNS = ("locomotion", "action", "truth", "aligned", "group", "example", "claim")


@dataclass(frozen=True)
class Pair:
    """A locomotion and an action to splice.

    truth: a clip of the bank, or LOCOMOTION+ACTION of the built-in motions, or empty if unknown. example: a title for
    the report. claim: a key of `bench.quality.claims.CLAIMS`. aligned: `yes` if the truth is another take or gait of
    the action, to be aligned to the locomotion by its legs; empty if it has the locomotion's legs frame by frame.
    group: of pairs whose mean the report shows.
    """

    locomotion: str
    action: str
    truth: str = ""
    example: str = ""
    claim: str = ""
    aligned: str = ""
    group: str = ""


def read_pairs(file: Path) -> list[Pair]:
    """Reads pairs from a CSV file with the columns locomotion and action, and optionally those of COLUMNS.

    Raises SettingsError with the file and line.
    """
    try:
        with file.open(newline="", encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SettingsError(f"cannot be read: {error}", file=str(file)) from None
    pairs = []
    for line, row in enumerate(rows, 2):
        if unknown := [str(column) for column in row if column not in COLUMNS]:
            mend = f"The columns are {', '.join(COLUMNS)}"
            raise SettingsError(f"unknown column {unknown[0]!r}", file=str(file), place=f"line {line}", mend=mend)
        if not (row.get("locomotion") and row.get("action")):
            raise SettingsError("locomotion or action is missing", file=str(file), place=f"line {line}")
        pair = Pair(**{column: value.strip() for column, value in row.items() if value})
        if pair.claim and pair.claim not in CLAIMS:
            mend = did_you_mean(pair.claim, CLAIMS)
            raise SettingsError(f"unknown claim {pair.claim!r}", file=str(file), place=f"line {line}", mend=mend)
        if pair.aligned not in ("", "yes"):
            problem = f"aligned is {pair.aligned!r}, expected yes or nothing"
            raise SettingsError(problem, file=str(file), place=f"line {line}")
        pairs.append(pair)
    return pairs


def grid_pairs() -> list[Pair]:
    """Returns every built-in action on every built-in locomotion, each with its generated truth."""
    return [Pair(locomotion, action, f"{locomotion}+{action}") for locomotion in LOCOMOTIONS for action in ACTIONS]


def pairs_of_bank(bank: Bank) -> list[Pair]:
    """Returns every action of a bank on every locomotion, with no truth. Raises SettingsError if there are too many."""
    names: dict[str, list[str]] = {"locomotion": [], "action": []}
    for clip in bank.clips:
        names[clip.kind].append(clip.name)
    pairs = [Pair(locomotion, action) for locomotion in names["locomotion"] for action in names["action"]]
    if not 0 < len(pairs) <= MOST_PAIRS:
        problem = f"the bank has {len(pairs)} pairs of a locomotion and an action, expected 1 to {MOST_PAIRS}"
        raise SettingsError(problem, mend="Choose some in a CSV file, with --pairs")
    return pairs


def has_built_in_clips(bank: Bank) -> bool:
    """Returns whether a bank has all built-in locomotions and actions, by name."""
    return {*LOCOMOTIONS, *ACTIONS} <= {clip.name for clip in bank.clips}


def truth_of(pair: Pair, bank: Bank) -> Clip | None:
    """Returns the truth of a pair on the bank's skeleton, None if unknown.

    Raises UnknownClipError, SettingsError for unknown built-in motions, or ClipError if they cannot be aligned.
    """
    if not pair.truth:
        return None
    locomotion, _, action = pair.truth.partition("+")
    if locomotion in LOCOMOTIONS and action in ACTIONS:
        generated = truth(locomotion, action)
        return onto_rig(generated, find_roles(generated.skeleton), Rig(bank.skeleton, bank.roles)).clip
    if pair.aligned:
        return aligned_truth(bank.motion(pair.locomotion), bank.motion(pair.truth), bank.roles)
    return bank.motion(pair.truth)
