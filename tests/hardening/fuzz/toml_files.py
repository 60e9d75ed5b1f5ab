"""`clips.toml`, `hands.toml` and files of roles: their keys with values of every type, and damage."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

from motionsplice.motion.clip_settings import VALUES, read_clip_settings
from motionsplice.motion.role_names import OPTIONAL
from motionsplice.motion.roles import LIMBS, read_roles_file
from motionsplice.precompute.hands.settings import read_hand_settings
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw
from tests.hardening.fuzz.held import Held, held
from tests.hardening.fuzz.text import encoded

SOUND = {
    "kind": '"action"', "neutral": '"walk"', "mask": '"arms"', "tags": '["a", "b"]', "skip_frames": "1", "unit": '"cm"',
    "up": '"z"', "rate": "120", "root": '"Hips"', "mirror": "true", "roles": '"roles.toml"', "body": '"walk"',
    "hands": '"wave"', "hand": '"left"', "wrist": "true", "turn": '"trunk"', "bands": "[0.3, 0.1]",
    "pairs": '["12:9", "20:30~2"]',
}  # fmt: skip
HAND_KEYS = ("body", "hands", "hand", "wrist", "turn", "bands", "pairs")
SCALARS = (
    *('""', '"walk"', "'x'", '"""a\nb"""', '"\\ud800"', '"\\u0000"', '"🙂"', "true", "false", "nan", "-inf", "1e999"),
    *("0", "-1", "1_000", "0x7fffffffffffffff", "0o7", "1.5", "-0.0", "1979-05-27", "07:32:00", "99:99:99"),
    *("1979-05-27T07:32:00Z", "0000-00-00", "2023-02-30", "9" * 30, "9" * 5000, "1" + "0" * 400, "x", "="),
)
TABLES = ("walk", '"moves:run"', "moves", "'a b'", "a.b", '""', "0", "roles", "hands")


def _value(draw: Draw, depth: int = 0) -> str:
    kind = draw.randrange(8)
    if kind == 6 and depth < 4:
        return f"[{', '.join(_value(draw, depth + 1) for _ in range(draw.randrange(4)))}]"
    if kind == 7 and depth < 4:
        return f"{{{', '.join(f'k{at} = {_value(draw, depth + 1)}' for at in range(draw.randrange(3)))}}}"
    if draw.rarely(12):
        deep = draw.choice((2, 30, 500))
        return draw.choice(("[" * deep + "]" * deep, "{a = " * deep + "1" + "}" * deep, f"[{'1, ' * deep}]"))
    return draw.choice(SCALARS)


def _line(draw: Draw, key: str) -> str:
    value = _value(draw) if draw.rarely(6) else SOUND.get(key, '"Hips"')
    key = draw.choice((f"{key}.{key}", f'"{key}"', "x", "")) if draw.rarely(30) else key
    return f"{key} = {value}{'  # why' if draw.rarely(20) else ''}"


def _table(draw: Draw, head: str, keys: list[str]) -> list[str]:
    head = draw.choice(("[x]", "[[x]]", "[", "[[hands]]", "[a.b]", "[roles]")) if draw.rarely(20) else head
    return [head, *(_line(draw, key) for key in keys)]


def _clips(draw: Draw) -> list[str]:
    lines: list[str] = []
    for at in range(draw.randrange(4)):
        name = draw.choice(TABLES) if draw.rarely(4) else f"clip{at}"
        lines += _table(draw, f"[{name}]", draw.sample(sorted(VALUES), draw.randrange(5)))
    return lines


def _hands(draw: Draw) -> list[str]:
    lines: list[str] = []
    for at in range(1 + draw.randrange(3)):
        keys = ["body", "hands", *draw.sample(HAND_KEYS[2:], draw.randrange(4))]
        lines += [line.replace('"walk"', f'"walk{at}"') for line in _table(draw, "[[hands]]", keys)]
    return lines


def _roles(draw: Draw) -> list[str]:
    return _table(draw, "[roles]", ["spine", *draw.sample((*LIMBS, *OPTIONAL, "pelvis"), draw.randrange(6))])


FILES: Mapping[str, tuple[Callable[[Draw], list[str]], Callable[[Held], object]]] = {  # with how each is made and read
    "clips.toml": (_clips, read_clip_settings),
    "hands.toml": (_hands, read_hand_settings),
    "roles.toml": (_roles, read_roles_file),
}


def make(draw: Draw) -> Files:
    """Returns one of the files."""
    name = draw.choice(tuple(FILES))
    return {name: encoded(draw, FILES[name][0](draw))}


def enter(files: Files, folder: Path) -> None:
    """Reads the file."""
    for name, place in held(files, folder).items():
        FILES[name][1](place)


EARLY = re.compile(r"the file is not TOML.*line 1,")
DOOR = Door(make, enter, EARLY)
