"""Commands over a WebSocket: their keys and values by the protocol, with other values, and done on a scene."""

from __future__ import annotations

import json
import re
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


def _sound(draw: Draw, key: str) -> Any:
    """Returns a value that the key may have."""
    clip, number = draw.choice(("walk", "run", "wave", "hail")), draw.random()
    choices: dict[str, Any] = {
        "locomotion": (clip, {clip: number, "walk": 1}, f"{clip}~mirror"),
        "weights": ({clip: number, "walk": 1}, {}),
        "action": (clip, f"{clip}~mirror"),
        "hands": (None,),
        "curve": get_args(Curve),
        "when": get_args(When),
        "mask": get_args(Mask),
        "own_clock": (True, False, [0.0, number]),
        "point": ([number, 1.0, 2.0], None, [1e9, -1e9, 0.0]),
        "direction": ([0.0, number, 1.0], None, [1e-300, 0.0, 0.0]),
        "part": get_args(AimPart),
        "position": ([number, 0.0, 1.0], [1e9, 0.0, 0.0]),
        "heading": (number, -1e9),
        "in_place": (True, False),
        "lock_feet": (True, False),
        "loop": (True, False),
        "events": (list(EVENT_NAMES.values()), []),
        "speed": (number, 0.0, 8.0),
        "method": ("splice", "naive"),
        "posture": get_args(Posture),
        "to": (["vmc"], []),
        "rate": (30.0, 1.0, 1000.0),
        "ahead": (1, 30),
    }
    return draw.choice(choices.get(key, (number, 0.0, 1.0)))


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
    commands: Any = [_command(draw) for _ in range(1 + draw.randrange(6))]
    if draw.rarely(6):
        damage_value(commands, draw)
    if draw.rarely(30):
        commands = draw.choice((commands[0], commands * 30, [commands], {"a": commands}, [{"id": list(range(5000))}]))
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
