"""`hands.toml`: which hands the offline job lays on which bodies, and how.

[[hands]]
body = "count_steps"             # a clip
hands = "count_steps_hands"      # a hands clip, which does not become a clip of the bank
hand = "right"                   # or "left", "both" (one alignment; the default) or "each" (one per hand)
wrist = true                     # also wrists and the twist of forearms; the default is fingers only
turn = "trunk"                   # turn hands onto the body's by the trunks; the default is "window"
bands = [0.3, 0.1]               # half widths of the two passes' bands, as parts of the body's frames
pairs = ["120:95", "300:288~5"]  # frames of body and hands that belong together; ~5: within 5 frames of the hands
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

from motionsplice.motion.errors import MotionError, SettingsError, did_you_mean
from motionsplice.motion.roles import SIDES, Side
from motionsplice.motion.storage.place import Place
from motionsplice.motion.toml_file import read_toml
from motionsplice.precompute.hands.align import BANDS
from motionsplice.precompute.hands.banded_warp import FramePair

FILE_NAME = "hands.toml"
HandChoice = Literal["left", "right", "both", "each"]
Turn = Literal["window", "trunk"]


@dataclass(frozen=True)
class HandSettings:
    """How hands are laid on a body (docs/hands.md).

    Attributes:
        hand: Which hands: `left`, `right`, `both` (aligned together) or `each` (aligned separately).
        wrist: Whether the wrists and the twist of the forearms are taken too, not the fingers only.
        turn: How the hands are turned onto the body's before frames are compared: `window` by the best fit of a few
            frames, `trunk` by the headings of the trunks.
        bands: Half widths of the bands of the two passes, as parts of the body's frames, above 0 and at most 1.
        pairs: Frames of body and hands that belong together, counted in both clips as they were read.
    """

    hand: HandChoice = "both"
    wrist: bool = False
    turn: Turn = "window"
    bands: tuple[float, float] = BANDS
    pairs: tuple[FramePair, ...] = ()

    @property
    def groups(self) -> tuple[tuple[Side, ...], ...]:
        """The sides in groups that are aligned together."""
        if self.hand == "each":
            return tuple((side,) for side in SIDES)
        return (SIDES,) if self.hand == "both" else ((self.hand,),)


@dataclass(frozen=True)
class HandsOnBody:
    """A hands clip, the body that it is laid on, and the settings.

    Attributes:
        body: The name of the body's clip.
        hands: The name of the hands clip.
        settings: How the hands are laid on the body.
    """

    body: str
    hands: str
    settings: HandSettings = HandSettings()

    @property
    def label(self) -> str:
        """The name of the task in messages: "HANDS on BODY"."""
        return f"{self.hands} on {self.body}"

    @classmethod
    def parse(cls, text: str) -> HandsOnBody:
        """Parses "BODY:HANDS", the names of two clips.

        Args:
            text: For example "count_steps:count_steps_hands".

        Returns:
            The two names, with the default settings.

        Raises:
            SettingsError: A name is missing.
        """
        body, colon, hands = text.partition(":")
        if not (body and colon and hands):
            problem = f"{text!r} does not name a body and its hands"
            raise SettingsError(problem, mend="Write BODY:HANDS, the names of two clips")
        return cls(body, hands)


def read_hand_settings(file: Place) -> list[HandsOnBody]:
    """Reads the entries of a `hands.toml`. Raises SettingsError with the entry and the key."""
    document = read_toml(file)
    entries = document.get("hands")
    if set(document) != {"hands"} or not isinstance(entries, list) or not all(isinstance(one, dict) for one in entries):
        problem = "it must hold [[hands]] tables and nothing else"
        raise SettingsError(problem, file=str(file), mend="Write [[hands]] before each entry")
    found: dict[str, HandsOnBody] = {}
    for number, table in enumerate(entries, 1):
        entry = _entry(number, table, str(file))
        if entry.label in found:
            before = list(found).index(entry.label) + 1
            problem = f"{entry.label} already exists, as hands {before}"
            mend = 'Remove one of the two; to align both hands separately, use hand = "each"'
            raise SettingsError(problem, file=str(file), place=f"hands {number}", mend=mend)
        found[entry.label] = entry
    return list(found.values())


def _entry(number: int, entry: Mapping[str, Any], file: str) -> HandsOnBody:
    """Checks one table of the file. Raises SettingsError."""
    where = f"hands {number}"
    known = ("body", "hands", "hand", "wrist", "turn", "bands", "pairs")
    for key in entry:
        if key not in known:
            raise SettingsError(f"unknown key {key!r:.80}", file=file, place=where, mend=did_you_mean(key, known))
    for key, wanted in (("body", "a clip"), ("hands", "a hands clip")):
        if key not in entry:
            mend = f'Add {key} = "NAME", the name of {wanted}'
            raise SettingsError(f"the key {key!r} is missing", file=file, place=where, mend=mend)
    bands, pairs = entry.get("bands", list(BANDS)), entry.get("pairs", [])
    for key, valid, wanted in (
        ("body", isinstance(entry.get("body"), str), "the name of a clip"),
        ("hands", isinstance(entry.get("hands"), str), "the name of a hands clip"),
        ("hand", entry.get("hand", "both") in get_args(HandChoice), f"one of {', '.join(get_args(HandChoice))}"),
        ("wrist", isinstance(entry.get("wrist", False), bool), "true or false"),
        ("turn", entry.get("turn", "window") in get_args(Turn), f"one of {', '.join(get_args(Turn))}"),
        ("bands", _are_numbers(bands), "two parts of the clip, such as [0.3, 0.1]"),
        ("pairs", _are_texts(pairs), 'a list of frame pairs, such as ["120:95"]'),
    ):
        if not valid:
            raise SettingsError(
                f"{key} = {entry.get(key)!r:.80} is not valid", file=file, place=where, mend=f"{key} must be {wanted}"
            )
    try:
        parsed = tuple(FramePair.parse(pair) for pair in pairs)
    except MotionError as error:
        raise SettingsError(error.problem, file=file, place=f"{where}, {error.place}", mend=error.mend) from None
    settings = HandSettings(
        entry.get("hand", "both"), entry.get("wrist", False), entry.get("turn", "window"), (bands[0], bands[1]), parsed
    )
    return HandsOnBody(entry["body"], entry["hands"], settings)


def _are_numbers(values: object) -> bool:
    """Returns whether `values` is a list of two numbers; a bool is not a number."""
    return isinstance(values, list) and len(values) == 2 and all(type(value) in (int, float) for value in values)


def _are_texts(values: object) -> bool:
    return isinstance(values, list) and all(isinstance(value, str) for value in values)
