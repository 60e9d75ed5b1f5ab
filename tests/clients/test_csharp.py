"""The C# client (clients/csharp), compiled by mono: golden files, malformed frames, playback."""

from __future__ import annotations

import base64
import json
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motionsplice.motion.axes import AXES
from motionsplice.service.characters.frame_format import FrameFormat
from motionsplice.service.wire.encoding import NUMBERS, Encoding
from tests.clients.mono import GOLDEN, ROOT, SOURCES, compiled, needs_mono, printed
from tests.service.messages import arrays, blob_offsets

pytestmark = needs_mono
UNITS = {"unreal": 100.0}  # units in a metre


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client, the Unity components and the tests' program."""
    return compiled(tmp_path_factory.mktemp("csharp") / "program.exe", SOURCES)


def base64_of(message: bytes) -> str:
    return base64.b64encode(message).decode()


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("encoding", NUMBERS)
def test_golden_files_are_decoded_and_joints_placed(program: Path, axes: str, encoding: str) -> None:
    message = (GOLDEN / f"characters.{axes}.{encoding}.msgpack").read_bytes()
    (found,) = printed(program, "frames", GOLDEN / f"rig.{axes}.json", lines=[base64_of(message)])
    expected = json.loads((GOLDEN / f"characters.{axes}.{encoding}.json").read_text())
    assert [found[key] for key in ("frame", "count", "rate", "time", "ids")] == [
        expected[key] for key in ("frame", "count", "rate", "time", "ids")
    ]
    unit, most = UNITS.get(axes, 1.0), 1e-5 if encoding == "float32" else 1e-4
    assert np.abs(np.array(found["places"]) - np.ravel(expected["world_positions"])).max() < most * unit
    rotations = np.array(expected["rotations"]) / (1.0 if encoding == "float32" else 32767.0)
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    assert np.abs(np.array(found["rotations"]) - rotations.ravel()).max() < 1e-6
    for key in ("root_steps", "root_turns"):
        np.testing.assert_allclose(found[key], np.ravel(expected[key]), rtol=1e-6)


def test_malformed_frames_are_errors_and_nothing_else(program: Path) -> None:
    """Cut, changed and random messages: the program ends at any other exception."""
    random = np.random.default_rng(1)
    messages = []
    for encoding in NUMBERS:
        whole = (GOLDEN / f"characters.gltf.{encoding}.msgpack").read_bytes()
        starts = np.array(list(blob_offsets(whole).values()))
        messages += [whole[: random.integers(len(whole))] for _ in range(500)]
        for _ in range(2000):
            changed = bytearray(whole)
            for _ in range(random.integers(1, 4)):  # most of them in heads, fields and ids
                at = (
                    random.integers(len(whole))
                    if random.random() < 0.2
                    else random.choice(starts) - random.integers(1, 40)
                )
                changed[max(int(at), 0)] = random.integers(256)
            messages.append(bytes(changed))
    messages += [random.bytes(int(random.integers(200))) for _ in range(1000)]
    found = printed(program, "frames", GOLDEN / "rig.gltf.json", lines=list(map(base64_of, messages)))
    assert len(found) == len(messages)
    errors = [one["error"] for one in found if "error" in one]
    assert 3000 < len(errors) < len(messages)  # a change in a float is not noticed
    assert all(error.startswith("malformed frames: ") for error in errors)


def message_of(
    number: int, rate: float, count: int, bank: str, random: np.random.Generator, form: FrameFormat
) -> bytes:
    """Returns a message of one character, with random rotations and root motion."""
    frames = []
    for _ in range(count):
        rotations = Rotation.random(22, random).as_quat().astype(np.float32)[None]
        root, step = random.random((2, 1, 3)).astype(np.float32)
        turn = random.random(1).astype(np.float32)
        frames.append({"root_steps": step, "root_turns": turn, "root_positions": root, "rotations": rotations})
    return form.writer(bank, rate, frames)(number, 1.8e9 + number / rate, np.array([7], np.uint32), 0, 1)


@pytest.mark.parametrize(("ahead", "rate"), [(1, 60.0), (8, 60.0), (3, 10.0)])
def test_pictures_are_those_of_the_protocols_playback(program: Path, tmp_path: Path, ahead: int, rate: float) -> None:
    """Messages that are late, lost and repeated, and another bank: the same pictures as the page's own program."""
    random = np.random.default_rng(ahead)
    form = FrameFormat(Encoding(AXES["gltf"], "float32", "local"), deltas=True)
    (page,) = re.findall(r"^class Playback:\n.*?(?=\n\n\nwith )", (ROOT / "docs/protocol.md").read_text(), re.M | re.S)
    (imports,) = re.findall(
        r"^import json, struct, time\n.*?namedtuple\(.*?\)\n", (ROOT / "docs/protocol.md").read_text(), re.M | re.S
    )
    names: dict[str, Any] = {}
    exec(imports + page, names)
    timeline: list[tuple[float, bytes | None]] = []
    for number in range(0, int(15 * rate), ahead):
        due = 100.0 + number / rate
        if random.random() < 0.03 or 4.0 < number / rate < 4.5:
            continue  # lost
        bank = "a" * 32 if number / rate < 8.0 else "b" * 32
        timeline.append((due + random.exponential(0.004), message_of(number, rate, ahead, bank, random, form)))
        if ahead > 1 and random.random() < 0.1:  # a command changes the frames from the second on
            timeline.append((due + 0.02, message_of(number + 1, rate, ahead, bank, random, form)))
    timeline += [(moment, None) for moment in np.arange(100.1, 115.0, 1 / 144)]
    timeline.sort(key=lambda one: one[0])
    lines = [
        f"message {now!r} {base64_of(message)}" if message else f"picture {float(now)!r}" for now, message in timeline
    ]
    found = iter(printed(program, "playback", GOLDEN / "rig.gltf.json", lines=lines))
    playback, before, blended = names["Playback"](rate), None, 0
    for now, message in timeline:
        if message:
            playback.take(message, now)
            continue
        root, rotations = playback.at(now, now - (now if before is None else before))
        before = now
        picture = next(found)
        np.testing.assert_allclose(picture["root"], root, atol=1e-5, err_msg=f"at {now}")
        np.testing.assert_allclose(np.reshape(picture["rotations"], (-1, 4)), rotations, atol=1e-4)
        blended += not isinstance(root, tuple)
    assert next(found, None) is None
    assert blended > 1000


def test_root_motion_is_added_up_and_jumps_are_not_interpolated(program: Path) -> None:
    """Frames arrive when they are due, so that pictures lag by a frame; `place` moves the character in frame 7."""
    random = np.random.default_rng(5)
    form = FrameFormat(Encoding(AXES["gltf"], "float32", "local"), deltas=True)
    messages = [message_of(number, 10.0, 1, "a" * 32, random, form) for number in range(12)]
    lines = [f"message {100 + number / 10} {base64_of(message)}" for number, message in enumerate(messages)]
    moments = np.arange(100.12, 101.1, 0.03)
    lines += ["place 100.51 7", *(f"picture {moment}" for moment in moments)]
    lines.sort(key=lambda line: float(line.split()[1]))
    pictures = printed(program, "playback", GOLDEN / "rig.gltf.json", lines=lines)
    read = [arrays(msgpack.unpackb(message), 22, 1, 1) for message in messages]
    ground, heading, expected = np.zeros(3), 0.0, []
    for number, (here, there) in enumerate(pairwise(read)):
        if number == 7:
            ground, heading = np.array([5.0, 0.0, 0.0]), 1.0
        step = Rotation.from_rotvec([0.0, heading, 0.0]).apply(there["root_steps"][0, 0])
        turn = float(there["root_turns"].item())
        expected.append((here["root_positions"], there["root_positions"], ground, step, heading, turn))
        ground, heading = ground + step, heading + turn
    for moment, picture in zip(moments, pictures, strict=True):
        position = float(moment - 100.1) * 10.0
        share = 0.0 if int(position) == 6 else position % 1.0
        a, b, ground, step, heading, turn = expected[int(position)]
        np.testing.assert_allclose(picture["root"], (a + share * (b - a))[0, 0], atol=1e-4)
        np.testing.assert_allclose(picture["ground"], [*(ground + share * step), heading + share * turn], atol=1e-4)
