"""`hands.toml`: which hands the offline job should lay on which bodies, and what a user knows of that.

[[hands]]
body = "count_steps"             # a clip
hands = "count_steps_hands"      # a clip of hands, which is then no other clip of the bank
hand = "right"                   # or "left", "both" (by one alignment) or "each" (by two); both if nothing is said
wrist = true                     # wrists and the twist of forearms too, not fingers alone
turn = "trunk"                   # turned as the trunks are, not by a window of frames
bands = [0.3, 0.1]
pairs = ["120:95", "300:288~5"]  # frames of body and hands that go together, give or take 5 frames of the hands
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from motionsplice.motion.errors import MotionError, SettingsError, did_you_mean
from motionsplice.motion.hand_joints import SIDES, Side
from motionsplice.precompute.hands.align import BANDS
from motionsplice.precompute.hands.banded_warp import FramePair

FILE_NAME = "hands.toml"
HandChoice = Literal["left", "right", "both", "each"]
Turn = Literal["window", "trunk"]


@dataclass(frozen=True)
class HandSettings:
    """How hands are laid on a body. pairs are in frames of both clips as they were read."""

    hand: HandChoice = "both"
    wrist: bool = False
    turn: Turn = "window"
    bands: tuple[float, float] = BANDS
    pairs: tuple[FramePair, ...] = ()

    @property
    def groups(self) -> tuple[tuple[Side, ...], ...]:
        """The hands that are aligned together."""
        if self.hand == "each":
            return tuple((side,) for side in SIDES)
        return (SIDES,) if self.hand == "both" else ((self.hand,),)


@dataclass(frozen=True)
class HandsOnBody:
    """Names of a clip of hands and of the body that they are laid on, and how."""

    body: str
    hands: str
    settings: HandSettings = HandSettings()

    @property
    def label(self) -> str:
        return f"{self.hands} on {self.body}"

    @classmethod
    def parse(cls, text: str) -> HandsOnBody:
        """From "body:hands". Raises SettingsError."""
        body, colon, hands = text.partition(":")
        if not (body and colon and hands):
            raise SettingsError(f"{text!r} names no body and its hands", mend="Write BODY:HANDS, two names of clips")
        return cls(body, hands)


def read_hand_settings(file: Path) -> list[HandsOnBody]:
    """The entries of a `hands.toml`. Raises SettingsError, naming the entry and the key."""
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"it is not TOML: {error}", file=str(file)) from None
    entries = document.get("hands")
    if set(document) != {"hands"} or not isinstance(entries, list) or not all(isinstance(one, dict) for one in entries):
        raise SettingsError("it needs tables called hands", file=str(file), mend="Write [[hands]] before each")
    found: dict[str, HandsOnBody] = {}
    for number, entry in enumerate(entries, 1):
        one = _entry(number, entry, str(file))
        if one.label in found:
            before = list(found).index(one.label) + 1
            problem = f"{one.label} is there already, as hands {before}"
            mend = 'Leave one of them out; hand = "each" aligns both apart'
            raise SettingsError(problem, file=str(file), place=f"hands {number}", mend=mend)
        found[one.label] = one
    return list(found.values())


def _entry(number: int, entry: Mapping[str, Any], file: str) -> HandsOnBody:
    where = f"hands {number}"
    known = ("body", "hands", "hand", "wrist", "turn", "bands", "pairs")
    for key in entry:
        if key not in known:
            raise SettingsError(f"unknown key {key!r}", file=file, place=where, mend=did_you_mean(key, known))
    for key, wanted in (("body", "a clip"), ("hands", "a clip of hands")):
        if key not in entry:
            mend = f'Write {key} = "NAME", the name of {wanted}'
            raise SettingsError(f"it has no key {key!r}", file=file, place=where, mend=mend)
    bands, pairs = entry.get("bands", list(BANDS)), entry.get("pairs", [])
    for key, sound, wanted in (
        ("body", isinstance(entry.get("body"), str), "the name of a clip"),
        ("hands", isinstance(entry.get("hands"), str), "the name of a clip of hands"),
        ("hand", entry.get("hand", "both") in get_args(HandChoice), f"one of {', '.join(get_args(HandChoice))}"),
        ("wrist", isinstance(entry.get("wrist", False), bool), "true or false"),
        ("turn", entry.get("turn", "window") in get_args(Turn), f"one of {', '.join(get_args(Turn))}"),
        ("bands", _are_numbers(bands), "two parts of 1"),
        ("pairs", isinstance(pairs, list) and all(isinstance(one, str) for one in pairs), 'such as ["120:95"]'),
    ):
        if not sound:
            raise SettingsError(
                f"{key} = {entry.get(key)!r} means nothing", file=file, place=where, mend=f"{key}: {wanted}"
            )
    try:
        read = tuple(FramePair.parse(one) for one in pairs)
    except MotionError as error:
        raise SettingsError(error.problem, file=file, place=f"{where}, {error.place}", mend=error.mend) from None
    settings = HandSettings(
        entry.get("hand", "both"), entry.get("wrist", False), entry.get("turn", "window"), (bands[0], bands[1]), read
    )
    return HandsOnBody(entry["body"], entry["hands"], settings)


def _are_numbers(values: object) -> bool:
    return isinstance(values, list) and len(values) == 2 and all(type(one) in (int, float) for one in values)
