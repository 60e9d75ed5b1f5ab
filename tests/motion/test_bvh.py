from __future__ import annotations

import itertools
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats import bvh
from motionsplice.motion.formats.bvh.reader import _contents, _plain_contents
from motionsplice.motion.formats.bvh.turns import fill_rotations
from motionsplice.motion.formats.fold import fold
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.skeleton import Skeleton

SMALL = """HIERARCHY
ROOT Hips
{
  OFFSET 0 1 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Chest
  {
    OFFSET 0 0.5 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 0.25 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
1 2 3 10 20 30 5 6 7
2 3 4 11 21 31 6 7 8
"""
ORDERS = ["".join(order) for order in itertools.permutations("XYZ")]
ODD_WORDS = [
    b"inf",
    b"nan",
    b"1e999",
    b"1e-320",
    b"-1",
    b"0",
    b"1e308",
    b"",
    b"{",
    b"}",
    b"\nEnd Site\n{\n",
    b"\nMOTION\n",
]
angles = st.floats(-180.0, 180.0)


def clip_of(text: str | bytes) -> Clip:
    nodes, rate, *_ = bvh.parse(text.encode() if isinstance(text, str) else text)
    folded = fold(nodes, 0)
    return Clip("clip", folded.skeleton, rate, folded.root_positions, folded.rotations)


def test_joints_rate_positions_and_rotations_are_read() -> None:
    clip = clip_of(SMALL)
    assert clip.skeleton.names == ("Hips", "Chest")
    assert clip.rate == 30.0
    np.testing.assert_allclose(clip.root_positions, [[1, 2, 3], [2, 3, 4]])
    np.testing.assert_allclose(clip.skeleton.offsets[1], [0, 0.5, 0])
    np.testing.assert_allclose(clip.skeleton.end_offsets, [[0, 0.25, 0]])
    expected = Rotation.from_euler("ZXY", [[10, 20, 30], [11, 21, 31]], degrees=True).as_quat()
    assert quaternion.angle(clip.rotations[:, 0], expected).max() < 1e-9


@pytest.mark.parametrize("order", ORDERS)
@given(values=st.tuples(angles, angles, angles))
def test_every_euler_order_agrees_with_scipy(order: str, values: tuple[float, float, float]) -> None:
    channels = " ".join(f"{axis}rotation" for axis in order)
    text = SMALL.replace("CHANNELS 3 Zrotation Xrotation Yrotation", f"CHANNELS 3 {channels}")
    text = text.replace("5 6 7", " ".join(map(repr, values)))
    expected = Rotation.from_euler(order, values, degrees=True).as_quat()
    assert quaternion.angle(clip_of(text).rotations[0, 1], expected) < 1e-7


@given(order=st.permutations(bvh.CHANNELS), values=st.lists(angles, min_size=6, max_size=6))
def test_channels_may_be_in_any_order(order: list[str], values: list[float]) -> None:
    text = SMALL.replace("Xposition Yposition Zposition Zrotation Xrotation Yrotation", " ".join(order))
    clip = clip_of(text.replace("1 2 3 10 20 30", " ".join(map(repr, values))))
    given_values = dict(zip(order, values, strict=True))
    np.testing.assert_allclose(clip.root_positions[0], [given_values[f"{axis}position"] for axis in "XYZ"])
    turns = [channel for channel in order if channel.endswith("rotation")]
    expected = Rotation.from_euler(
        "".join(turn[0] for turn in turns), [given_values[turn] for turn in turns], degrees=True
    )
    assert quaternion.angle(clip.rotations[0, 0], expected.as_quat()) < 1e-7


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace(" ", " \t  "),
        lambda text: text.replace("\n", "\n\n"),
        lambda text: text.replace("rotation", "ROTATION").replace("HIERARCHY", "hierarchy").replace("JOINT", "Joint"),
        lambda text: text.replace("{", "{ ").rstrip("\n"),
        lambda text: text.replace("Chest\n  {", "Chest {").replace("End Site\n    {", "End Site {"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("Frames: 2", "Frames:2").replace("Frame Time: ", "Frame Time:\t"),
    ],
)
def test_white_space_and_case_do_not_matter(change: object) -> None:
    changed, plain = clip_of(change(SMALL)), clip_of(SMALL)  # type: ignore[operator]
    np.testing.assert_array_equal(changed.rotations, plain.rotations)
    np.testing.assert_array_equal(changed.root_positions, plain.root_positions)


@pytest.mark.parametrize(
    ("step", "rate"),
    [
        ("0.0333333", 30.0),
        (".0083333", 120.0),
        ("0.0083", 120.0),
        ("0.01666", 60.0),
        ("0.04", 25.0),
        ("1", 1.0),
        ("0.0166833", 60.0 / 1.001),
        ("0.03336667", 30.0 / 1.001),
        ("4.17083333e-2", 24.0 / 1.001),
    ],
)
def test_a_rounded_step_means_a_whole_rate_or_that_of_video(step: str, rate: float) -> None:
    assert clip_of(SMALL.replace("0.0333333", step)).rate == pytest.approx(rate, rel=1e-12)


def test_names_keep_colons_and_spaces() -> None:
    assert clip_of(SMALL.replace("Chest", "rig:the chest")).skeleton.names[1] == "rig:the chest"


def test_a_joint_without_channels_does_not_move() -> None:
    text = SMALL.replace("    CHANNELS 3 Zrotation Xrotation Yrotation\n", "")
    clip = clip_of(text.replace(" 5 6 7", "").replace(" 6 7 8", ""))
    np.testing.assert_array_equal(clip.rotations[:, 1], np.tile(quaternion.IDENTITY, (2, 1)))


@given(st.integers(0, 10**6))
def test_a_clip_survives_writing_and_reading(seed: int) -> None:
    draw = np.random.default_rng(seed)
    joints, frames = int(draw.integers(1, 12)), int(draw.integers(1, 6))
    parents = np.array([-1] + [int(draw.integers(0, joint)) for joint in range(1, joints)])
    ends = draw.integers(0, joints, 3)
    skeleton = Skeleton(
        tuple(f"j{joint}" for joint in range(joints)),
        parents,
        np.concatenate([np.zeros((1, 3)), draw.normal(size=(joints - 1, 3))]),
        ends,
        draw.normal(size=(3, 3)),
    )
    rotations = Rotation.random(frames * joints, random_state=seed).as_quat().reshape(frames, joints, 4)
    clip = Clip(
        "clip", skeleton, float(draw.choice([24.0, 30.0, 60.0, 120.0])), draw.normal(size=(frames, 3)), rotations
    )
    unit = float(draw.choice([1.0, 0.01]))
    again = clip_of(bvh.dump_bvh(clip, unit))
    order = [again.skeleton.names.index(name) for name in skeleton.names]
    assert again.rate == clip.rate
    assert quaternion.angle(again.rotations[:, order], clip.rotations).max() < 1e-5
    np.testing.assert_allclose(again.root_positions * unit, clip.root_positions, atol=1e-6)
    np.testing.assert_allclose(joint_positions(again)[:, order] * unit, joint_positions(clip), atol=1e-4)
    assert len(again.skeleton.end_parents) == 3


def test_moving_parents_are_folded_into_the_root() -> None:
    text = SMALL.replace("CHANNELS 3 Zrot", "CHANNELS 6 Xposition Yposition Zposition Zrot")
    text = text.replace("5 6 7", "0 0.5 0 5 6 7").replace("6 7 8", "0 0.7 0 6 7 8")
    nodes, *_ = bvh.parse(text.encode())
    whole, folded = fold(nodes, 0), fold(nodes, 1)
    assert folded.skeleton.names == ("Chest",)
    turned = quaternion.rotate(whole.rotations[:, 0], [[0, 0.5, 0], [0, 0.7, 0]])
    np.testing.assert_allclose(folded.root_positions, whole.root_positions + turned)
    expected = quaternion.multiply(whole.rotations[:, 0], whole.rotations[:, 1])
    np.testing.assert_allclose(folded.rotations[:, 0], expected)
    assert "left out: Hips" in folded.notes[0]


def test_a_moving_inner_joint_is_fixed_and_noted() -> None:
    text = SMALL.replace("CHANNELS 3 Zrot", "CHANNELS 6 Xposition Yposition Zposition Zrot")
    moving = fold(bvh.parse(text.replace("5 6 7", "0 0.5 0 5 6 7").replace("6 7 8", "0 0.9 0 6 7 8").encode())[0], 0)
    np.testing.assert_allclose(moving.skeleton.offsets[1], [0, 0.7, 0])
    assert moving.notes[0] == "move on their parents, fixed at their median offsets: Chest"
    steady = fold(bvh.parse(text.replace("5 6 7", "0 0.6 0 5 6 7").replace("6 7 8", "0 0.6 0 6 7 8").encode())[0], 0)
    np.testing.assert_allclose(steady.skeleton.offsets[1], [0, 0.6, 0])
    assert not steady.notes


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "ends inside the hierarchy"),
        ("hello world", "line 1: expected HIERARCHY, the first word of a BVH file, found 'hello world'"),
        (b"\x00\x01\x02", "binary"),
        (bytes(1000), "empty but for padding"),
        (SMALL[: SMALL.index("  CHANNELS 6")], "ends inside the hierarchy.*cut short"),
        (SMALL[: SMALL.index("MOTION")], "before MOTION"),
        (SMALL[: SMALL.index("Frame Time")], "before the frames"),
        (
            SMALL[:-9],
            r"line 20, frame 1: expected 9 values per frame, found 5. Export the file again; it may be cut short",
        ),
        (SMALL.replace("20 30", "nan 30"), "line 19, frame 0: 'nan' is not a finite number"),
        (SMALL.replace("20 30", "inf 30"), "'inf' is not a finite number"),
        (SMALL.replace("20 30", "1e999 30"), "not a finite number"),
        (SMALL.replace("20 30", "2O 30"), "'2O' is not a finite number"),
        (SMALL.replace("20 30", "20"), "frame 0: expected 9 values per frame, found 8"),
        (SMALL.replace("6 7\n2 3 4", "6\n7 2 3"), "line 19, frame 0: expected 9 values per frame, found 8"),
        (SMALL[: SMALL.index("Frames")] + "Frames: 0\nFrame Time: 0.1\n", "no frames"),
        (SMALL.replace("Frames: 2", "Frames: 2.5"), "the header is invalid"),
        (SMALL.replace("0.0333333", "0"), "the header is invalid"),
        (SMALL.replace("0.0333333", "30"), "seconds per frame"),
        (SMALL.replace("0.0333333", "1e-320"), "the header is invalid"),
        (SMALL.replace("Frames: 2", "Frames: inf"), "the header is invalid"),
        (SMALL.replace("0.0333333", "soon"), "line 18: expected .*'Frame Time: seconds', found 'Frame Time: soon'"),
        (SMALL.replace("OFFSET 0 0.5 0", "OFFSET 0 0.5"), "line 8: OFFSET needs three"),
        (SMALL.replace("    OFFSET 0 0.5 0\n", ""), "'Chest' has no OFFSET"),
        (SMALL.replace("CHANNELS 3", "CHANNELS 999999999"), "line 9: CHANNELS declares 999999999, but names 3"),
        (SMALL.replace("Xrotation", "Wrotation"), "unknown channel 'Wrotation'"),
        (SMALL.replace("CHANNELS 3 Zrotation Xrotation", "CHANNELS 3 Zrotation Zrotation"), "twice"),
        (
            SMALL.replace("    CHANNELS 3", "    CHANNELS 1 Xrotation\n    CHANNELS 3"),
            "line 10: .*'Chest' has a second CHANNELS line",
        ),
        (SMALL.replace("0 0.25 0", "0 0.25 0\nCHANNELS 1 Xrotation"), "line 13: an End Site cannot have CHANNELS"),
        (
            SMALL.replace("0 0.25 0", "0 0.25 0\nEnd Site\n{\nOFFSET 0 1 0\n}"),
            "line 13: an End Site cannot have children",
        ),
        (
            SMALL.replace("0 0.25 0", "0 0.25 0\nJOINT A\n{\nOFFSET 0 1 0\n}"),
            "line 13: an End Site cannot have children",
        ),
        (SMALL.replace("JOINT", "ROOT"), "line 6: expected a ROOT with named JOINTs below it"),
        (SMALL.replace("JOINT Chest", "JOINT"), "line 6"),
        (SMALL.replace("}\nMOTION", "}\n}\nMOTION"), "line 16"),
    ],
)
def test_a_malformed_file_is_refused_with_the_place_of_the_error(text: str | bytes, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        bvh.parse(text.encode() if isinstance(text, str) else text)


def test_deep_nesting_is_read_without_recursion() -> None:
    depth = 10_000
    opening = "".join(
        f"{'JOINT' if n else 'ROOT'} j{n}\n{{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n" for n in range(depth)
    )
    text = f"HIERARCHY\n{opening}" + "}\n" * depth + f"MOTION\nFrames: 1\nFrame Time: 0.1\n{'0 ' * depth}\n"
    assert len(bvh.parse(text.encode())[0].names) == depth


def test_joints_without_channels_cannot_take_far_more_memory_than_their_file() -> None:
    joints = "".join(f"JOINT j{joint}\n{{\nOFFSET 0 1 0\n}}\n" for joint in range(10_000))
    head = f"HIERARCHY\nROOT r\n{{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n{joints}}}\nMOTION\n"
    with pytest.raises(FormatError, match="100000 frames of 10001 joints"):
        bvh.parse(f"{head}Frames: 100000\nFrame Time: 0.1\n".encode() + b"0\n" * 100_000)


@given(st.data())
def test_any_mutated_file_is_read_or_refused(data: st.DataObject) -> None:
    text = bytearray(SMALL.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        match data.draw(st.integers(0, 3)):
            case 0:
                text[at] = data.draw(st.integers(0, 255))
            case 1:
                del text[at : at + data.draw(st.integers(1, 40))]
            case 2:  # replace a whole word
                words = bytes(text).split(b" ")
                words[data.draw(st.integers(0, len(words) - 1))] = data.draw(st.sampled_from(ODD_WORDS))
                text = bytearray(b" ".join(words))
            case _:
                text[at:at] = text[data.draw(st.integers(0, len(text) - 1)) :][:30]
        if not text:
            break
    with suppress(MotionError):
        assert clip_of(bytes(text)).frame_count > 0


def test_people_in_real_files_stand_on_the_floor(real_motion: Path) -> None:
    nodes, rate, *_ = bvh.parse((real_motion / "06_01.bvh").read_bytes())
    folded = fold(nodes, 0)
    clip = Clip("walk", folded.skeleton.scaled(0.05644), rate, folded.root_positions * 0.05644, folded.rotations)
    assert clip.rate == 120.0
    heights = joint_positions(clip)[1:, :, 1]
    assert -0.05 < np.percentile(heights.min(axis=1), 50) < 0.1
    assert 1.4 < np.median(heights.max(axis=1)) < 1.9


PIECES = (
    *ODD_WORDS,
    b"\r",
    b"\r\n",
    b"\x0b",
    b"\0",
    b"\xe5\xb7\xa6",
    b"\xff",
    b",",
    b" # 1",
    b"\nFrames: 2\nFrame Time: 0.5\n",
)


@given(st.data())
def test_frames_straight_from_bytes_are_those_of_the_text(data: st.DataObject) -> None:
    changed = bytearray(SMALL.encode())
    for _ in range(data.draw(st.integers(0, 2))):
        at, length = data.draw(st.integers(0, len(changed))), data.draw(st.integers(0, 3))
        changed[at : at + length] = data.draw(st.sampled_from(PIECES))
    plain = _plain_contents(bytes(changed))
    if plain is not None:
        whole = _contents(bytes(changed))
        assert (plain.hierarchy, plain.header) == (whole.hierarchy, whole.header)
        np.testing.assert_array_equal(plain.frames.values, whole.frames.values)
        assert plain.frames.warnings == whole.frames.warnings == ()


def test_a_plain_file_is_read_straight_from_bytes() -> None:
    for ending in ("\n", "\r\n"):
        assert _plain_contents(SMALL.replace("\n", ending).encode()) is not None


@pytest.mark.parametrize("order", ["z", "zx", "zxy"])
def test_the_kernel_composes_turns_as_quaternions_do(order: str) -> None:
    random, joints = np.random.default_rng(2), np.array([3, 0])
    values, columns = random.uniform(-360.0, 360.0, (300, 7)), random.permutation(7)[: 2 * len(order)].reshape(2, -1)
    rotations = np.zeros((300, 4, 4))
    fill_rotations(rotations, joints, order, values, columns)
    halves = 0.5 * np.radians(values[:, columns])
    wanted = quaternion.from_euler(order, np.sin(halves), np.cos(halves))
    np.testing.assert_allclose(rotations[:, joints], wanted, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(rotations[:, [1, 2]], 0.0)
