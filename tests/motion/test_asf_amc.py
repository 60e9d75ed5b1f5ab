from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.errors import FormatError, MotionError
from motionsplice.motion.formats.asf_amc import parse_motion, parse_skeleton
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions

ASF = """# a comment
:version 1.10
:name VICON
:units
  mass 1.0
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name thigh
    direction 0 -1 0
    length 2
    axis 0 0 20 XYZ
    dof rx rz
    limits (-160 20)
           (-70 70)
  end
  begin
    id 2
    name shin
    direction 0 -1 0
    length 3
    axis 0 0 0 XYZ
  end
:hierarchy
  begin
    root thigh
    thigh shin
  end
"""
AMC = """#!OML:ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 10 20 30
thigh 40 50
2
root 1 2 4 11 21 31
thigh 41 51
"""


def test_joints_are_where_bones_begin() -> None:
    skeleton = parse_skeleton(ASF.encode())
    nodes, rate, *_ = parse_motion(AMC.encode(), skeleton)
    assert nodes.names == ("root", "thigh", "shin")
    assert nodes.parents.tolist() == [-1, 0, 1]
    np.testing.assert_allclose(nodes.offsets, [[0, 0, 0], [0, 0, 0], [0, -2, 0]])
    np.testing.assert_allclose(nodes.end_offsets, [[0, -3, 0]])
    assert skeleton.unit == pytest.approx(0.056444, abs=1e-6)
    assert rate == 120.0


def test_rotations_are_about_each_bones_own_axes() -> None:
    nodes, *_ = parse_motion(AMC.encode(), parse_skeleton(ASF.encode()))
    axes = Rotation.from_euler("xyz", [0, 0, 20], degrees=True)
    thigh = axes * Rotation.from_euler("xyz", [40, 0, 50], degrees=True) * axes.inv()
    assert quaternion.angle(nodes.rotations[0, 1], thigh.as_quat()) < 1e-9
    root = Rotation.from_euler("xyz", [10, 20, 30], degrees=True)
    assert quaternion.angle(nodes.rotations[0, 0], root.as_quat()) < 1e-9
    np.testing.assert_allclose(nodes.translations[0], [[1, 2, 3], [1, 2, 4]])
    np.testing.assert_array_equal(nodes.rotations[:, 2], np.tile(quaternion.IDENTITY, (2, 1)))


def test_radians_the_rate_and_other_orders_of_the_root_are_read() -> None:
    asf = ASF.replace("order TX TY TZ RX RY RZ", "order RZ RY RX TZ TY TX")
    amc = AMC.replace(":DEGREES", ":RADIANS\n:SAMPLES-PER-SECOND 60").replace("1 2 3 10 20 30", "0.1 0.2 0.3 3 2 1")
    nodes, rate, *_ = parse_motion(amc.encode(), parse_skeleton(asf.encode()))
    assert rate == 60.0
    np.testing.assert_allclose(nodes.translations[0][0], [1, 2, 3])
    assert quaternion.angle(nodes.rotations[0, 0], Rotation.from_euler("zyx", [0.1, 0.2, 0.3]).as_quat()) < 1e-9


def test_a_byte_order_mark_does_not_matter() -> None:
    plain, *_ = parse_motion(AMC.encode(), parse_skeleton(ASF.encode()))
    marked, *_ = parse_motion(("\ufeff" + AMC).encode(), parse_skeleton(("\ufeff" + ASF).encode()))
    np.testing.assert_array_equal(marked.rotations, plain.rotations)


@pytest.mark.parametrize(
    ("asf", "amc"),
    [
        (ASF, AMC.replace(":FULLY-SPECIFIED\n:DEGREES\n", "")),
        (ASF, AMC.replace("thigh", "Thigh")),
        (ASF, AMC.replace("thigh 41", "THIGH 41").replace("root", "Root")),
        (ASF.replace("    thigh shin", "    Thigh Shin"), AMC),
        (ASF, AMC.replace("2\nroot", "# a comment\n2\nroot")),
        (ASF, AMC.replace("1\nroot", "7\nroot").replace("2\nroot", "8\nroot")),
        (ASF, AMC.replace("\n", "\r") + "\x1a\0\0"),
        (ASF.encode("utf-16"), AMC.encode("utf-16")),
    ],
)
def test_small_liberties_do_not_matter(asf: str | bytes, amc: str | bytes) -> None:
    plain = parse_motion(AMC.encode(), parse_skeleton(ASF.encode()))
    skeleton = parse_skeleton(asf.encode() if isinstance(asf, str) else asf)
    found = parse_motion(amc.encode() if isinstance(amc, str) else amc, skeleton)
    np.testing.assert_array_equal(found.nodes.rotations, plain.nodes.rotations)
    np.testing.assert_array_equal(found.nodes.translations[0], plain.nodes.translations[0])
    assert (found.nodes.names, found.unit, found.notes, found.warnings) == (plain.nodes.names, plain.unit, (), ())


def test_decimal_commas_are_read_and_noted() -> None:
    skeleton = parse_skeleton(ASF.replace("0.45", "0,45").encode())
    assert skeleton.unit == parse_skeleton(ASF.encode()).unit
    found = parse_motion(AMC.replace("40 50", "40,5 50,25").encode(), skeleton)
    plain = parse_motion(AMC.replace("40 50", "40.5 50.25").encode(), skeleton)
    np.testing.assert_array_equal(found.nodes.rotations, plain.nodes.rotations)
    assert found.notes == ("its decimal commas were read as decimal points",)
    with pytest.raises(FormatError, match=r"'1,040\.5' is not a finite number"):
        parse_motion(AMC.replace("40 50", "1,040.5 50").encode(), skeleton)


def test_without_a_unit_of_length_it_is_left_open() -> None:
    assert parse_skeleton(ASF.replace("  length 0.45\n", "").encode()).unit is None
    assert parse_skeleton(ASF.replace(":units\n  mass 1.0\n  length 0.45\n  angle deg\n", "").encode()).unit is None


@given(st.permutations(range(1, 7)))
def test_frames_are_sorted_by_their_numbers(numbers: list[int]) -> None:
    frames = {number: f"{number}\nroot {number} 2 3 10 20 {number}\nthigh 40 {number}\n" for number in numbers}
    skeleton = parse_skeleton(ASF.encode())
    plain = parse_motion("".join(frames[number] for number in sorted(numbers)).encode(), skeleton)
    mixed = parse_motion("".join(frames[number] for number in numbers).encode(), skeleton)
    np.testing.assert_array_equal(mixed.nodes.rotations, plain.nodes.rotations)
    np.testing.assert_array_equal(mixed.nodes.translations[0], plain.nodes.translations[0])
    assert mixed.notes == (() if numbers == sorted(numbers) else ("its frames were sorted by their numbers",))


@pytest.mark.parametrize(
    ("numbers", "warnings"),
    [
        ([1, 2, 4, 5], ("frames are missing: the numbers of the frames jump after frame 2",)),
        ([5, 1, 2, 6], ("frames are missing: the numbers of the frames jump after frame 2",)),
        ([1, 5, 9, 13], ()),  # every fourth frame was kept
        ([1, 2, 1, 2], ()),  # two takes
    ],
)
def test_missing_frames_are_a_warning(numbers: list[int], warnings: tuple[str, ...]) -> None:
    text = "".join(f"{number}\nroot {place} 2 3 4 5 6\nthigh 1 2\n" for place, number in enumerate(numbers))
    found = parse_motion(text.encode(), parse_skeleton(ASF.encode()))
    assert found.warnings == warnings
    if warnings == ():
        np.testing.assert_array_equal(found.nodes.translations[0][:, 0], [0, 1, 2, 3])


@pytest.mark.parametrize("comment", ["", "# slowly, line by line\n"])
def test_bones_without_any_values_stay_at_rest_and_are_noted(comment: str) -> None:
    amc = AMC.replace("thigh 40 50\n", "").replace("thigh 41 51\n", comment)
    found = parse_motion(amc.encode(), parse_skeleton(ASF.encode()))
    np.testing.assert_array_equal(found.nodes.rotations[:, 1], np.tile(quaternion.IDENTITY, (2, 1)))
    assert found.notes == ("the motion has no values for these bones, which stay at rest: thigh",)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (ASF.replace("dof rx rz", "dof rx rx"), "'thigh' lists a degree of freedom twice"),
        ("", "no :root section"),
        (b"\x00\x01", "binary"),
        (ASF[: ASF.index(":hierarchy")], "no :hierarchy section"),
        (ASF.replace("  end\n:hierarchy", ":hierarchy"), "the last bone has no 'end' line"),
        (ASF.replace("direction 0 -1 0\n    length 3", "length 3"), "a bone has no direction"),
        (ASF.replace("length 3", "length nan"), "finite"),
        (ASF.replace("length 3", "length three"), "line 28: expected a finite number, found 'three'"),
        (ASF.replace("dof rx rz", "dof rx l"), "degree of freedom 'l'"),
        (ASF.replace("order TX TY", "order TX TX"), "line 9: the root's order"),
        (ASF.replace("thigh shin\n", "thigh shim\n"), r"unknown bone 'shim'. Did you mean 'shin'"),
        (ASF.replace("thigh shin\n", "thigh thigh\n"), "'thigh' must have exactly one parent"),
        (ASF.replace("    thigh shin\n", ""), "'shin' has no parent"),
        (ASF.replace("name shin", "name thigh"), "two bones have the name 'thigh'"),
        (ASF.replace("length 0.45", "length -1"), "must be positive"),
        (ASF.replace("20 XYZ", "20 XXZ"), "'xxz' is not an order of axes"),
    ],
)
def test_a_malformed_skeleton_is_refused_with_the_place_of_the_error(text: str | bytes, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        parse_skeleton(text.encode() if isinstance(text, str) else text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no frames"),
        (b"1\nroot 1 2 3 4 5 6\x00 7", "binary"),
        (AMC[: AMC.index("thigh 41")], "frame 1 has no values for bone 'thigh'"),
        (AMC.replace("thigh 40 50\n", ""), "line 6: frame 0 has no values for bone 'thigh'"),
        (
            AMC.replace("thigh 41 51", "thigh 41"),
            "frame 1, bone 'thigh': expected 2 values, one for each degree of freedom, found 1",
        ),
        (
            AMC.replace("40 50", "40").replace("41 51", "41 51 2"),
            "frame 0, bone 'thigh': expected 2 values, .* found 1",
        ),
        (AMC.replace("thigh 41 51", "thigh"), "line 9, frame 1"),
        (AMC.replace("thigh 41 51", "thing 41 51"), r"no moving bone 'thing'. Did you mean 'thigh'"),
        (AMC.replace("thigh 41 51", "shin 41 51"), "no moving bone 'shin'"),
        (AMC.replace("thigh 41 51", "thigh 41 inf"), "frame 1, bone 'thigh': 'inf' is not a finite number"),
        (AMC.replace("thigh 41 51", "thigh 41 five"), "'five' is not a finite number"),
        (AMC.replace("thigh 41 51", "thigh 41 51\nthigh 41 51"), "line 10, frame 1"),
        (AMC.replace("1\nroot", "root", 1), "expected one line with values for bone 'root'"),
    ],
)
def test_a_malformed_motion_is_refused_with_the_place_of_the_error(text: str | bytes, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        parse_motion(text.encode() if isinstance(text, str) else text, parse_skeleton(ASF.encode()))


@given(st.data())
def test_any_mutated_file_is_read_or_refused(data: st.DataObject) -> None:
    texts = [bytearray(ASF.encode()), bytearray(AMC.encode())]
    text = texts[data.draw(st.integers(0, 1))]
    at = data.draw(st.integers(0, len(text) - 1))
    if data.draw(st.booleans()):
        text[at] = data.draw(st.integers(0, 255))
    else:
        del text[at : at + data.draw(st.integers(1, 60))]
    with suppress(MotionError):
        nodes, *_ = parse_motion(bytes(texts[1]), parse_skeleton(bytes(texts[0])))
        assert np.isfinite(nodes.rotations).all()


def test_people_in_real_files_walk_upright(real_motion: Path) -> None:
    for name in ("16_15", "02_01", "127_04"):
        reading = read_clip(real_motion / f"{name}.amc")
        positions, roles = joint_positions(reading.clip), reading.roles
        assert -0.05 < np.median(positions[:, :, 1].min(axis=1)) < 0.1
        assert 0.35 < np.median(positions[:, roles.left_knee, 1]) < 0.6
        assert positions[:, :, 1].argmax(axis=1).tolist().count(roles.head) > 0.9 * len(positions)
        assert 0.75 < roles.leg_length(reading.clip.skeleton) < 0.95
