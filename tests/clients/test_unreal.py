"""The Unreal plugin, compiled against stand-ins for the engine: what it pushes to Live Link, next to the kernels."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motionsplice.motion.axes import AXES, Axes
from motionsplice.motion.kinematics import world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import POSTURES, Posture
from motionsplice.runtime.stage import Stage
from tests import random_bank
from tests.clients import cpp

pytestmark = cpp.needs_compiler
PLUGIN = cpp.CLIENT.parent / "unreal"
MODULE = PLUGIN / "Source" / "MotionSplice"
PLAY = str(PLUGIN / "tests" / "play.cpp")
FOLDERS = [PLUGIN / "tests" / "stubs", MODULE / "Public", MODULE / "Private", cpp.CLIENT]
SOURCES = list(map(str, sorted(MODULE.glob("Private/*.cpp"))))
OPTIONS = [*(f"-I{folder}" for folder in FOLDERS), "-pthread"]
ONE_UNIT = [*(f"-include{source}" for source in SOURCES), *OPTIONS]  # as Unreal builds modules; it takes half the time
UNREAL = AXES["unreal"]
MESH = Axes("mesh", "left-handed, Z up, Y forward: glTF in Unreal", "centimetre", (0, 2, 1), (1, 1, 1), 100.0)
WAVE = Action("wave", blend=0.0)
CLOSE = 1e-3  # centimetres
Lines = list[tuple[str, Any]]


@pytest.fixture(scope="module")
def play(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program that runs the plugin."""
    return cpp.compiled(PLAY, tmp_path_factory.mktemp("unreal") / "play", "-O2", *cpp.BARE, *ONE_UNIT)


def printed(program: Path, bank: Path, *commands: str) -> Lines:
    """Runs the program; returns the keys and values that it prints, in order."""
    lines = [next(iter(json.loads(line).items())) for line in cpp.run(program, bank, "\n".join(commands))]
    assert [value for key, value in lines if key == "fault"] == []
    return lines


def values(lines: Lines, key: str) -> list[Any]:
    return [value for name, value in lines if name == key]


def placed(bank: Bank, transforms: Any) -> Floats:
    """World positions [n, J, 3] of transforms [n, J, 7] in Unreal's axes."""
    frames = np.array(transforms, np.float64)
    rig = replace(bank.skeleton, offsets=UNREAL.positions(bank.skeleton.offsets))
    np.testing.assert_allclose(frames[:, 1:, :3], np.broadcast_to(rig.offsets[1:], frames[:, 1:, :3].shape), atol=1e-9)
    return world_transforms(rig, frames[:, 0, :3], frames[:, :, 3:])[0]


def played(
    bank: Bank, locomotion: str, action: Action, rate: float, count: int, hands: str | None = None
) -> tuple[Floats, Floats]:
    """World positions [count, J, 3] in metres and world rotations [count, J, 4] of a character of the runtime."""
    characters = Characters(Stage(Evaluator(bank)), rate)
    characters.add(1, locomotion)
    characters.act(0, action)
    characters.wear(0, hands, blend=0.0)
    poses = characters.stage.evaluator.poses(1)
    roots, rotations = [], []
    for _ in range(count):
        characters.evaluate(poses)
        roots.append(poses.root_positions[0].copy())
        rotations.append(poses.rotations[0].copy())
        characters.advance()
    return world_transforms(bank.skeleton, np.array(roots, np.float64), np.array(rotations, np.float64))


@pytest.mark.parametrize(("compiler", "standard"), [("g++", "-std=c++20"), ("clang++", "-std=c++17")])
def test_the_plugin_compiles_without_warnings(compiler: str, standard: str) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    options = [standard, "-fsyntax-only", *cpp.BARE, *SOURCES, *OPTIONS]
    cpp.compiled(PLAY, Path("/dev/null"), *options, compiler=compiler)


def test_the_commands_of_the_readme_copy_all_that_the_plugin_needs(tmp_path: Path) -> None:
    blocks = re.findall(r"^ +```sh\n(.*?)^ +```", (PLUGIN / "README.md").read_text(encoding="utf-8"), re.S | re.M)
    [commands] = [block for block in blocks if "cp " in block]
    commands = commands.replace("MyGame", str(tmp_path))
    subprocess.run(["bash", "-eu", "-c", commands], cwd=cpp.CLIENT.parents[1], check=True)
    module = tmp_path / "Plugins" / "MotionSplice" / "Source" / "MotionSplice"
    assert (tmp_path / "Plugins" / "MotionSplice" / "MotionSplice.uplugin").is_file()
    options = [f"-I{folder}" for folder in (FOLDERS[0], module / "Public")]
    for source in module.glob("Private/*.cpp"):
        cpp.compiled(str(source), Path("/dev/null"), "-fsyntax-only", *cpp.BARE, *options)


@pytest.mark.parametrize(
    ("locomotion", "action", "posture"),
    [
        ("walk", "wave", "relative"),
        ("run", "carry_box", "running"),
        ("walk", "carry_box", "absolute"),
        ("walk", "wave~mirror", "relative"),
        ("run~mirror", "carry_box~mirror", "running"),
    ],
)
@pytest.mark.parametrize("rate", [60.0, 24.0])
def test_bones_are_where_the_runtime_places_them(
    bank: Bank, play: Path, locomotion: str, action: str, posture: Posture, rate: float
) -> None:
    assert bank.clip(locomotion).loop
    settings = [f"set locomotion {locomotion}", f"set action {action}", f"set posture {POSTURES[posture]}"]
    lines = printed(play, bank.path, *settings, f"set rate {rate}", "character 700")
    positions, _ = played(bank, locomotion, Action(action, blend=0.0, posture=posture), rate, 700)
    np.testing.assert_allclose(placed(bank, values(lines, "frame")), UNREAL.positions(positions), atol=CLOSE)


@pytest.mark.parametrize("action", ["counting", "counting~mirror"])
def test_hands_are_those_of_the_runtime(hands_bank: Bank, play: Path, action: str) -> None:
    settings = [f"set action {action}", "set hands counting_hands"]
    lines = printed(play, hands_bank.path, *settings, "character 400")
    positions, _ = played(hands_bank, "walk", Action(action, blend=0.0), 60.0, 400, "counting_hands")
    pushed = placed(hands_bank, values(lines, "frame"))
    np.testing.assert_allclose(pushed, UNREAL.positions(positions), atol=CLOSE)
    bare, _ = played(hands_bank, "walk", Action(action, blend=0.0), 60.0, 400)
    assert np.abs(pushed - UNREAL.positions(bare)).max() > 1.0


def test_a_clip_without_a_loop_begins_again_where_it_ended(play: Path, tmp_path: Path) -> None:
    candidates = (random_bank.random_bank(seed, 8, 2, 3, "torso") for seed in range(100))
    bank = next(bank for bank in candidates if bank.clips[0].loop == 0)
    frames = bank.clips[0].frame_count
    settings = [f'set locomotion "{bank.clips[0].name}"', f"set rate {bank.clips[0].rate}"]
    lines = printed(play, cpp.written(bank, tmp_path / "bank"), *settings, f"character {2 * frames}")
    pushed = np.array(values(lines, "frame"))
    np.testing.assert_allclose(pushed[frames : 2 * frames - 2, 1:], pushed[1 : frames - 1, 1:], atol=1e-5)


def test_a_source_pushes_its_bones_once_and_frames_at_its_rate(bank: Bank, play: Path) -> None:
    lines = printed(play, bank.path, "set action wave", "set rate 120", "start", "wait 120", "until Active", "stop")
    [[subject, *bones]] = values(lines, "bones")
    assert subject == "motionsplice"
    assert bones == [list(bone) for bone in zip(bank.skeleton.names, bank.skeleton.parents.tolist(), strict=True)]
    assert values(lines, "valid") == [True]
    frames = values(lines, "frame")
    assert {frame[0] for frame in frames} == {subject}
    numbers = 120.0 * (np.array([frame[1] for frame in frames]) - frames[0][1])
    np.testing.assert_allclose(numbers, np.round(numbers), atol=1e-4)
    assert np.diff(np.round(numbers)).min() == 1
    positions, _ = played(bank, "walk", WAVE, 120.0, round(numbers[-1]) + 1)
    expected = UNREAL.positions(positions)[np.round(numbers).astype(int)]
    np.testing.assert_allclose(placed(bank, [frame[2] for frame in frames]), expected, atol=CLOSE)


def test_settings_take_effect_while_the_source_plays(bank: Bank, play: Path) -> None:
    changes = ["set action wave", "set in_place 1", "set subject hero", "set rate 240", "set locomotion run"]
    commands = [command for change in changes for command in (change, "wait 9")]
    lines = printed(play, bank.path, "start", "wait 9", *commands, "stop")
    parts: list[Lines] = [[]]
    for line in lines:
        parts.append([]) if line[0] in ("before", "after") else parts[-1].append(line)
    # the frame that is evaluated during a change may still be the old one
    plain, waving, in_place, hero, fast, running = (values(part, "frame")[1:] for part in parts[::2])

    def arm(frame: Any) -> Floats:
        return np.array(frame[2][bank.skeleton.names.index("RightArm")][3:])

    def ahead(frame: Any) -> float:
        return float(frame[2][0][0])

    assert np.abs(arm(waving[0]) - arm(plain[-1])).max() > 0.1
    assert ahead(waving[-1]) > 10.0
    assert max(abs(ahead(frame)) for frame in in_place) < 5.0
    assert {frame[0] for frame in in_place} == {"motionsplice"}
    assert {frame[0] for frame in hero} == {"hero"}
    assert [value[0] for value in values(lines, "bones")] == ["motionsplice", "hero"]
    assert values(lines, "removed") == ["motionsplice"]
    assert np.diff([frame[1] for frame in fast]).min() < 1.1 / 240.0
    positions, _ = played(bank, "run", WAVE, 240.0, 240)
    heights = UNREAL.positions(positions)[:, 0, 2]
    assert min(abs(heights - running[0][2][0][2])) < CLOSE
    assert values(lines, "log") == []


@pytest.mark.parametrize(
    ("change", "restored", "status"),
    [
        ("bank /nowhere/else", None, "/nowhere/else: this folder is not a bank. Build one with `motionsplice "),
        ("bank -", None, "no bank. Choose the bank's folder in the source's settings."),
        ("locomotion jump", "locomotion walk", 'unknown clip "jump". `motionsplice inspect` lists the bank\'s clips.'),
        ("action walk\u00e9", "action wave", 'unknown clip "walk\u00e9". '),
        ("hands none", "hands -", 'unknown clip "none". '),
    ],
)
@pytest.mark.parametrize("playing", [True, False])
def test_errors_are_the_status_and_end_when_they_are_corrected(
    bank: Bank, play: Path, change: str, restored: str | None, status: str, playing: bool
) -> None:
    start = ["start", "wait 2", f"set {change}"] if playing else [f"set {change}", "start"]
    commands = [
        *start,
        f"until {status.split()[0]}",
        f"set {restored or f'bank {bank.path}'}",
        "wait 2",
        "until Active",
    ]
    lines = printed(play, bank.path, *commands, "stop")
    [refused, active] = values(lines, "status")
    assert refused.startswith(status)
    assert active == "Active"
    assert values(lines, "valid") == [False, True]
    assert values(lines, "log") == [refused]


@pytest.mark.parametrize(("setting", "own"), [("locomotion", '"clip 0"'), ("action", "-")])
def test_a_rig_without_a_mirror_image_is_the_status(play: Path, tmp_path: Path, setting: str, own: str) -> None:
    bank = random_bank.random_bank(2, 8, 2, 3, "torso")
    lame = replace(bank, manifest=replace(bank.manifest, mirror=None))
    changes = [f'set {setting} "clip 1~mirror"', "until the", f"set {setting} {own}", "until Active", "stop"]
    lines = printed(play, cpp.written(lame, tmp_path / "bank"), 'set locomotion "clip 0"', "start", "wait 2", *changes)
    refused, active = values(lines, "status")
    assert refused.startswith("the bank has no clip 'clip 1~mirror'. Its rig has no mirror image")
    assert active == "Active"


def test_a_damaged_bank_is_refused_and_its_file_named(bank: Bank, play: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copytree(bank.path, tmp_path / "b\u00e4nk", ignore=shutil.ignore_patterns("cache")))
    table = next((copy / "tables").iterdir())
    table.write_bytes(table.read_bytes()[:-1])
    lines = printed(play, copy, "start", f"until {copy}", "stop")
    assert values(lines, "log") == values(lines, "status")
    assert values(lines, "log")[0].startswith(f"{copy}/tables/{table.name}: ")


@pytest.mark.parametrize("sanitizer", ["thread", "address"])
def test_a_source_ends_in_every_state(bank: Bank, tmp_path: Path, sanitizer: str) -> None:
    options = ["-g", f"-fsanitize={sanitizer}", "-fno-sanitize-recover=all", *ONE_UNIT]
    program = cpp.compiled(PLAY, tmp_path / "play", *options)
    for end in ("stop", "destroy"):
        commands = ["start", end, "start", "wait 5", "set action wave", "wait 5", end]
        commands += ["set bank -", "start", "until no", end, f"set bank {bank.path}", "start", "set rate 240", end]
        printed(program, bank.path, *commands)


def test_a_mesh_with_bone_axes_of_its_own_has_its_bones_where_the_runtime_places_them(bank: Bank, play: Path) -> None:
    draw, joints, parents = np.random.default_rng(5), bank.skeleton.joint_count, bank.skeleton.parents
    # a bone above the hips, turned, moved and scaled, as exporters add
    axes = Rotation.random(joints + 1, rng=draw)
    stand = world_transforms(bank.skeleton, np.zeros((1, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (1, joints, 1)))[0][0]
    points, scale = np.vstack([[3.0, -2.0, 7.0], MESH.positions(stand)]), 0.01
    lines = ["Armature -1 " + " ".join(map(repr, [*axes[0].as_quat().tolist(), *points[0].tolist(), scale]))]
    for joint, name in enumerate(bank.skeleton.names):
        bone, above = joint + 1, int(parents[joint]) + 1
        rotation = (axes[above].inv() * axes[bone]).as_quat().tolist()
        position = axes[above].inv().apply((points[bone] - points[above]) / scale).tolist()
        lines.append(f"{name} {above} " + " ".join(map(repr, [*rotation, *position, 1.0])))
    commands = ["set action wave", "character 100", f"mesh 90 {len(lines)}", *lines]
    [bones] = np.array(values(printed(play, bank.path, *commands), "mesh"))
    positions, rotations = played(bank, "walk", WAVE, 60.0, 100)
    np.testing.assert_allclose(bones[1:, :3], MESH.positions(positions[-1]), atol=CLOSE)
    turned = Rotation.from_quat(rotations[-1][:, [*MESH.order, 3]] * [*MESH.turns, 1.0]) * axes[1:]
    assert (Rotation.from_quat(bones[1:, 3:]).inv() * turned).magnitude().max() < 1e-5
    np.testing.assert_allclose(bones[0, :3], points[0], atol=1e-9)
