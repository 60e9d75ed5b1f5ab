"""Commands over a WebSocket: their keys and values by the protocol, with other values, and done on a scene."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, get_args

from bench.hostile.damage import damage_bytes, damage_text, damage_value
from motionsplice.motion.axes import AXES
from motionsplice.runtime.characters.aim import AimPart
from motionsplice.runtime.characters.state import EVENT_NAMES, Curve, Mask, When
from motionsplice.runtime.requests import Posture
from motionsplice.service.characters.commands import NEEDED, OPTIONAL, TARGETED, checked, cost, in_pieces, parse, ref_of
from motionsplice.service.characters.scene import Scene
from motionsplice.service.problems import RequestError
from motionsplice.service.serving import Edition
from tests.hardening.fuzz.banks import played_bank
from tests.hardening.fuzz.door import Door, Files
from tests.hardening.fuzz.draw import Draw

RATE, MOST = 60.0, 1000
LARGEST = 64 * 1024  # bytes of a message, as by default
CLIPS = ("walk", "run", "wave", "hail")
FRAMES = 2  # that are evaluated after the commands
MEMBERS = [{"do": "create", "id": [0, 1, 2], "locomotion": "walk"}]
ODD: tuple[Any, ...] = (
    None,
    True,
    "",
    "x",
    -1,
    0,
    1,
    1e308,
    -1e9,
    1e-320,
    [],
    {},
    [1, 2, 3],
    [0, 0, 0],
    {"walk": 0},
    {"run": 1e9},
)


Values = Callable[[str, float], tuple[Any, ...]]  # of the name of a clip and a number below 1
SOUND: Mapping[str, Values] = {
    "locomotion": lambda clip, number: (clip, {clip: number, "walk": 1}, f"{clip}~mirror"),
    "weights": lambda clip, number: ({clip: number, "walk": 1}, {}),
    "action": lambda clip, number: (clip, f"{clip}~mirror"),
    "own_clock": lambda clip, number: (True, False, [0.0, number]),
    "point": lambda clip, number: ([number, 1.0, 2.0], None, [1e9, -1e9, 0.0]),
    "direction": lambda clip, number: ([0.0, number, 1.0], None, [1e-300, 0.0, 0.0]),
    "position": lambda clip, number: ([number, 0.0, 1.0], [1e9, 0.0, 0.0]),
    "heading": lambda clip, number: (number, -1e9),
    "speed": lambda clip, number: (number, 0.0, 8.0),
}
SOUND_ANYWAY: Mapping[str, tuple[Any, ...]] = {
    "hands": (None,),
    "curve": get_args(Curve),
    "when": get_args(When),
    "mask": get_args(Mask),
    "part": get_args(AimPart),
    "in_place": (True, False),
    "lock_feet": (True, False),
    "loop": (True, False),
    "events": (list(EVENT_NAMES.values()), []),
    "method": ("splice", "naive"),
    "posture": get_args(Posture),
    "to": (["vmc"], []),
    "rate": (30.0, 1.0, 1000.0),
    "ahead": (1, 30),
}


def _sound(draw: Draw, key: str) -> Any:
    """Returns a value that the key may have."""
    if key in SOUND_ANYWAY:
        return draw.choice(SOUND_ANYWAY[key])
    clip, number = draw.choice(CLIPS), draw.random()
    return draw.choice(SOUND[key](clip, number) if key in SOUND else (number, 0.0, 1.0))


def _command(draw: Draw) -> dict[str, Any]:
    do = draw.choice(("play", "act", *NEEDED))
    optional = OPTIONAL.get(do, ())
    keys = [*NEEDED[do], *draw.sample(optional, draw.randrange(1 + len(optional)))]
    if do in TARGETED:
        keys = [key for key in keys if key not in ("point", "direction")] + [draw.choice(("point", "direction"))]
    command = {"do": do} | {key: _sound(draw, key) for key in keys}
    if do != "set":
        command["id"] = draw.choice((0, [0, 1, 2], 1, [2, 0]))
    if do == "create":
        command["id"] = draw.randrange(3, 40)
    if draw.rarely(6):
        command[draw.choice((*command, *optional, "id", "ref", "x"))] = draw.choice(ODD)
    return command


def make(draw: Draw) -> Files:
    """Returns a message."""
    commands: Any = [_command(draw) for _ in range(draw.choice((1, 1, 1, 2, 3)))]
    if draw.rarely(6):
        damage_value(commands, draw)
    if draw.rarely(30):
        commands = draw.choice((commands[0], commands * 30, [commands], {"a": commands}, [{"id": list(range(300))}]))
    text = json.dumps(commands).encode()
    if draw.rarely(10):
        text = draw.choice((damage_text, damage_bytes))(text, text, draw)
    return {"message": text[:LARGEST]}


@cache
def _scene() -> Scene:
    scene = Scene(Edition.warm(played_bank()), RATE, MOST)
    for command in checked(MEMBERS, AXES["gltf"]):
        scene.do(command)
    return scene


def enter(files: Files, folder: Path) -> None:
    """Does the commands of a message as a connection does, and makes the next frames."""
    try:
        text = files["message"].decode()
    except UnicodeDecodeError:
        raise RequestError("the frame is not text") from None  # by websockets
    scene = _scene().copy()
    cost(text)
    listed = parse(text)
    ref_of(listed)
    for piece in in_pieces(list(checked(listed, AXES["unreal"]))):
        for command in piece:
            if command.do != "set":
                scene.do(command)
    for _ in range(FRAMES):
        scene.evaluate(scene.edition.evaluator.poses(len(scene)))
        list(scene.advance())


EARLY = re.compile("the message is not|the frame is not|the list of commands|expected a command")
DOOR = Door(make, enter, EARLY)
