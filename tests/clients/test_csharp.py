"""The C# client (clients/csharp), compiled by mono: golden files, malformed frames, playback, a live service, Unity.

The Unity component is compiled and run against the stand-in for UnityEngine in tests/clients/csharp, not in Unity.
"""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from threading import Thread
from typing import Any

import msgpack
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from websockets.sync.server import ServerConnection, serve

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.service.characters.frame_format import FrameFormat
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from motionsplice.service.wire.axes import AXES
from motionsplice.service.wire.encoding import NUMBERS, Encoding
from tests.service.messages import arrays, blob_offsets
from tests.service.running import Running, running

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests" / "golden" / "files"
SOURCES = [*(ROOT / "clients" / "csharp").rglob("*.cs"), *(ROOT / "tests" / "clients" / "csharp").glob("*.cs")]
MISSING = shutil.which("mcs") is None or shutil.which("mono") is None
pytestmark = pytest.mark.skipif(MISSING, reason="mono is not installed: apt-get install mono-mcs mono-runtime")
MINUTES = 120.0  # seconds, far more than any run takes
UNITS = {"unreal": 100.0}  # units in a metre


def compiled(file: Path, sources: list[Path]) -> None:
    """Compiles a program without a warning."""
    references = [f"-r:{name}.dll" for name in ("System.Core", "System.Numerics", "System.Numerics.Vectors")]
    command = ["mcs", "-langversion:7.2", "-warnaserror", f"-out:{file}", *references, *map(str, sources)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client, the Unity components and the tests' program."""
    file = tmp_path_factory.mktemp("csharp") / "program.exe"
    compiled(file, SOURCES)
    return file


def printed(program: Path, *arguments: object, lines: list[str] | None = None) -> list[dict[str, Any]]:
    """Runs the program, and returns the maps that it prints."""
    command = ["mono", "--debug", str(program), *map(str, arguments)]
    text = "\n".join(lines or [])
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False, timeout=MINUTES)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


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
    return form.message(bank, number, rate, 1.8e9 + number / rate, np.array([7], np.uint32), frames)


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


@pytest.fixture(scope="module")
def other(clip_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """A newer bank: the run is another one."""
    clips = tmp_path_factory.mktemp("other") / "clips"
    shutil.copytree(clip_folder, clips)
    (clips / "run.bvh").write_bytes(dump_bvh(make("run", seed=12, seconds=4.0)))
    build_bank([clips], clips.parent / "bank", baseline="walk", jobs=1)
    return Bank.open(clips.parent / "bank")


@pytest.fixture(scope="module")
def service(bank: Bank) -> Iterator[Running]:
    with running(bank.path, Settings()) as service:
        yield service


@contextmanager
def started(program: Path, *arguments: object) -> Iterator[Callable[[], dict[str, Any]]]:
    """Runs the program, and gives the function that returns the next map that it prints."""
    command = ["mono", "--debug", str(program), *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        output, errors = process.stdout, process.stderr
        assert output is not None
        assert errors is not None

        def line() -> dict[str, Any]:
            text = output.readline()
            assert text, errors.read()
            return dict(json.loads(text))

        try:
            yield line
            assert process.wait(MINUTES) == 0, errors.read()
        finally:
            process.kill()


def test_joints_are_where_the_service_has_them_through_an_exchange_and_a_reconnection(
    program: Path, bank: Bank, other: Bank
) -> None:
    newer = Edition.warm(other)
    with running(bank.path, Settings()) as service, started(program, "live", service.url) as line:
        front, loop = service.config.front, service.server.servers[0].get_loop()
        assert line() == {"do": "", "ready": True}
        loop.call_soon_threadsafe(front.shared.serving.exchange, newer)
        assert line() == {"do": "", "exchanged": True}
        for connection in tuple(front.hub.connections):
            loop.call_soon_threadsafe(connection.close, 1011, "lost")
        results = line()["results"]
    assert [(one["encoding"], one["ahead"]) for one in results] == [
        (encoding, ahead) for encoding in ("float32", "int16") for ahead in (1, 8)
    ]
    for one in results:
        print({key: value for key, value in one.items() if key != "samples"})
        assert one["frames"] >= 1000
        assert one["banks"] == [bank.digest, other.digest]
        assert one["worst"] < (1e-5 if one["encoding"] == "float32" else 3e-4)  # of which int16 is nearly all
        assert one["characters"] == 3
        assert one["late"] >= 0  # a command that was given without a connection
        assert one["failures"] == ["the connection is lost: closed with code 1011 lost"]
        assert one["away"] >= 0.25  # seconds
        assert one["jump"] < 0.3  # metres, of 5.8 to the origin: it goes on where it was, at another phase of the stride
        assert one["held"] < 0.5  # the delay's
        assert len(one["samples"]) == 10
        for sample in one["samples"]:
            assert np.abs(placed(sample, one["encoding"]) - sample["positions"]).max() < 1e-5


def placed(sample: dict[str, Any], encoding: str) -> Any:
    """Returns the joints of a message, placed in 64 bits as the protocol describes, in the client's order."""
    message = msgpack.unpackb(base64.b64decode(sample["message"]))
    parents, offsets = sample["parents"], np.reshape(sample["offsets"], (-1, 3))
    ids = np.frombuffer(message["ids"], "<u4")
    found = arrays(message, len(parents), message["count"] * len(ids), short=encoding == "int16")
    places = [found["root_positions"].astype(float)]
    turns = [Rotation.from_quat(found["rotations"][:, 0])]
    for joint, parent in enumerate(parents[1:], 1):
        places.append(places[parent] + turns[parent].apply(offsets[joint]))
        turns.append(turns[parent] * Rotation.from_quat(found["rotations"][:, joint]))
    return np.stack(places, axis=1).ravel()


def test_a_service_that_misbehaves_is_reported_and_left(program: Path) -> None:
    """A malformed message, then silence; another protocol on the next connection."""
    welcome = {**json.loads((GOLDEN / "rig.gltf.json").read_text()), "event": "welcome", "protocol": 3}
    protocols = iter((3, 4))

    def misbehave(socket: ServerConnection) -> None:
        socket.send(json.dumps({**welcome, "protocol": next(protocols)}))
        for text in socket:
            (command,) = json.loads(text)
            socket.send(json.dumps({"event": "done", "ref": command["ref"], "frame": 0}))
            socket.send(b"\x80")

    with serve(misbehave, "127.0.0.1", 0) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        (found,) = printed(program, "failures", f"http://127.0.0.1:{server.socket.getsockname()[1]}")
    assert found["failures"] == [
        "malformed frames: found no frame, rate or time. Are client and service of one version?",
        "the connection is lost: no message for a while",
        "expected protocol 3, found 4",
    ]


def test_every_command_is_done_and_refusals_say_why(program: Path, service: Running) -> None:
    found, *failed = printed(program, "commands", service.url)
    assert len(found["frames"]) == 9
    assert found["frames"] == sorted(found["frames"])
    assert found["removed"] > found["frames"][-1]
    assert "stride" in found["events"]
    assert [text.partition(" ")[0].removeprefix("urn:motionsplice:") for text in found["refused"]] == [
        "unknown-clip",
        "request",
        "request",
        "unknown-clip",
    ]
    assert "Did you mean 'walk'" in found["refused"][0]
    assert repr('no "hands" \\ é') in found["refused"][3]
    assert found["heading"] == pytest.approx(-1.0, abs=0.3)  # placed there, and walking in centimetres since
    assert np.abs(np.subtract(found["ground"], [50.0, 60.0, 0.0])).max() < 100.0
    assert len(failed) == 2
    assert all(one["error"].startswith("cannot connect to ") for one in failed)


def test_unity_bones_with_axes_of_their_own_are_where_the_joints_are(program: Path, service: Running) -> None:
    (found,) = printed(program, "unity", service.url, "none")
    assert not found["errors"]
    assert found["pictures"] == 300
    assert found["worst"] < 1e-5
    assert np.linalg.norm(np.subtract(found["end"], found["start"])) > 0.5  # metres: root motion moves the object
    joints = json.loads(urllib.request.urlopen(f"{service.url}/v1/skeleton").read())["joints"]
    (found,) = printed(program, "unity", service.url, joints[2])
    assert found["errors"] == [f"hero: no bones are named {joints[2]}. Build the bank on this character's skeleton."]


def test_the_readmes_program_runs(service: Running, tmp_path: Path) -> None:
    example, _ = re.findall(r"```csharp\n(.*?)```", (ROOT / "clients/csharp/README.md").read_text(), re.DOTALL)
    (tmp_path / "Walker.cs").write_text(example)
    client = ROOT / "clients" / "csharp" / "MotionSplice.cs"
    compiled(tmp_path / "Walker.exe", [tmp_path / "Walker.cs", client])
    command = ["mono", "Walker.exe", service.url]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=MINUTES)
    lines = done.stdout.splitlines()
    assert len(lines) > 60, done.stderr
    assert all(line.endswith(" 22 joints") for line in lines)
    assert len(set(lines)) > 60  # it moves
