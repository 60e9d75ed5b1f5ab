"""BVH files as they are found: each test writes a small file with the peculiarity of some exporter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.motion.errors import FormatError
from motionsplice.motion.formats import bvh
from motionsplice.motion.formats.parsed import Parsed
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.skeleton import Skeleton

HIERARCHY = """HIERARCHY
ROOT Hips
{
  OFFSET 0 1.5 0
  CHANNELS 3 Xposition Yposition Zrotation
  JOINT Chest
  {
    OFFSET 0.25 0.5 0
    CHANNELS 1 Zrotation
    End Site
    {
      OFFSET 0 0.25 0
    }
  }
}
MOTION
"""
ROWS = ["1.5 2.25 3.5 4", "5.5 6.25 7.5 8", "9.5 10.25 11.5 12"]
SMALL = f"{HIERARCHY}Frames: 3\nFrame Time: 0.1\n" + "".join(f"{row}\n" for row in ROWS)
WALK = bvh.dump_bvh(make("walk", seconds=1.0), unit=0.01)


def parse(text: str | bytes) -> Parsed:
    return bvh.parse(text.encode() if isinstance(text, str) else text)


def assert_same(parsed: Parsed, frames: int = 3) -> None:
    """Checks that the first `frames` frames of SMALL were read."""
    plain = parse(SMALL)
    assert len(parsed.nodes.rotations) == frames
    np.testing.assert_array_equal(parsed.nodes.rotations, plain.nodes.rotations[:frames])
    np.testing.assert_array_equal(parsed.nodes.translations[0], plain.nodes.translations[0][:frames])
    np.testing.assert_array_equal(parsed.nodes.offsets, plain.nodes.offsets)
    np.testing.assert_array_equal(parsed.nodes.end_offsets, plain.nodes.end_offsets)
    assert parsed.nodes.names == plain.nodes.names
    assert parsed.rate == plain.rate


@pytest.mark.parametrize("declared", [0, -1, 1, 2, 4, 99999999999])
def test_other_counts_of_whole_frames_are_read_with_a_warning(declared: int) -> None:
    parsed = parse(SMALL.replace("Frames: 3", f"Frames: {declared}"))
    assert_same(parsed)
    assert parsed.warnings == (f"the header declares {declared} frames, but the file has 3; all 3 were read",)
    assert not parse(SMALL).warnings


def test_the_warning_reaches_the_reading(tmp_path: Path) -> None:
    lines = WALK.splitlines()
    (tmp_path / "walk.bvh").write_bytes(b"\n".join(lines[:-1]) + b"\n")
    reading = read_clip(tmp_path / "walk.bvh")
    assert "declares 61 frames, but the file has 60" in reading.warnings[0]
    assert reading.clip.frame_count == 60


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SMALL[:-9], "line 21, frame 2: expected 4 values per frame, found 2. .*cut short"),
        (SMALL[:-4], "line 21, frame 2: expected 4 values per frame, found 3. .*cut short"),
        (SMALL.replace("Frames: 3", "Frames: 2")[:-4], "line 21, frame 2: expected 4 .*cut short"),
        (SMALL.replace("11.5 12", "11.5 -"), "line 21, frame 2: the last frame ends in '-', .*cut short"),
        (SMALL.replace("11.5 12", "1.5e"), "line 21, frame 2: the last frame ends in '1.5e', .*cut short"),
        (
            SMALL.replace("Frames: 3", "Frames: 4").replace("10.25 11.5 12\n", "10.2 11.5 1"),
            "line 21: the last frame ends within a number, '1'",
        ),
        (SMALL.replace("Frames: 3", "Frames: 4").replace("7.5 8", "7.5"), "line 20, frame 1: expected 4 .* found 3"),
        (SMALL.replace("7.5 8", "7.5 8 9"), "line 20, frame 1: expected 4 values per frame, found 5"),
        (SMALL.replace("7.5 8", "7.5 eight"), "line 20, frame 1: 'eight' is not a finite number"),
    ],
)
def test_half_a_frame_is_refused(text: str, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        parse(text)


@pytest.mark.parametrize("tail", ["}\n", "HIERARCHY\nROOT A\n", "written by X v1.0, 2026\n", "nan nan nan nan\n"])
def test_other_lines_after_the_last_frame_are_left_out_with_a_warning(tail: str) -> None:
    parsed = parse(SMALL + tail)
    assert_same(parsed)
    assert parsed.warnings == (f"left out what follows the last frame, from line 22: {tail.splitlines()[0]!r}",)


@pytest.mark.parametrize("declared", [2, 5])
def test_other_lines_may_follow_other_counts_of_frames(declared: int) -> None:
    parsed = parse(SMALL.replace("Frames: 3", f"Frames: {declared}") + "}\n")
    assert_same(parsed)
    assert [warning.split()[0] for warning in parsed.warnings] == ["left", "the"]
    for tail in ("nan 1 2 3\n", "-\n", "}\n1 2 3 4\n"):
        with pytest.raises(FormatError, match="line 22, frame 3: "):
            parse(SMALL.replace("Frames: 3", "Frames: 5") + tail)


@given(st.integers(1, 11), st.booleans())
def test_frames_may_be_broken_over_lines(width: int, by_frame: bool) -> None:
    values = [row.split() for row in ROWS]
    rows = values if by_frame else [" ".join(ROWS).split()]
    lines = [" ".join(row[at : at + width]) for row in rows for at in range(0, len(row), width)]
    assert_same(parse(SMALL[: SMALL.index("1.5 2.25")] + "\n".join(lines)))


def test_broken_frames_need_no_right_count_if_they_end_with_lines() -> None:
    wrapped = SMALL.replace("Frames: 3", "Frames: 5").replace("5 3.5", "5\n3.5").replace("6.25 7.5", "6.25\n7.5")
    wrapped = wrapped.replace("10.25 ", "10.25\n")
    parsed = parse(wrapped)
    assert_same(parsed)
    assert "declares 5 frames, but the file has 3" in parsed.warnings[0]
    with pytest.raises(FormatError, match="line 23, frame 2: expected 4 values per frame, found 3"):
        parse(wrapped[:-4])


def test_frames_with_too_few_values_are_not_taken_for_broken_ones() -> None:
    halves = f"{HIERARCHY}Frames: 4\nFrame Time: 0.1\n" + "1 2\n" * 4
    with pytest.raises(FormatError, match="line 19, frame 0: expected 4 values per frame, found 2"):
        parse(halves)


def test_decimal_commas_are_read_and_noted() -> None:
    parsed = parse(SMALL.replace(".", ","))
    assert_same(parsed)
    assert parsed.notes == ("its decimal commas were read as decimal points",)


def test_commas_may_be_in_some_parts_only() -> None:
    header = SMALL.index("Frames")
    for text in (SMALL[:header].replace(".", ",") + SMALL[header:], SMALL[:header] + SMALL[header:].replace(".", ",")):
        parsed = parse(text.replace("0,1\n", "0.1\n"))
        assert_same(parsed)
        assert len(parsed.notes) == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SMALL.replace("1.5 2.25", "1,234.5 2.25"), "line 19, frame 0: .*unclear what the comma in '1,234.5' means"),
        (SMALL.replace("5.5 6.25", "1,234 6.25"), "line 20, frame 1: .*unclear what the comma in '1,234' means"),
        (SMALL.replace(".", ",").replace("1,5 2,25", "1,234,5 2,25"), "the comma in '1,234,5' .*thousands separators"),
        (SMALL.replace("1.5 2.25", "1.5, 2,25"), "the comma in '1.5,' .*decimal points, separated by blanks"),
        (SMALL.replace("0.25 0.5 0", "0,25 0.5 0"), "line 8: OFFSET needs three finite numbers, found '0,25 0.5 0'"),
    ],
)
def test_commas_that_may_mean_something_else_are_refused(text: str, words: str) -> None:
    text = text.replace("Frame Time: 0,1", "Frame Time: 0.1")
    with pytest.raises(FormatError, match=words):
        parse(text)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text + "\x1a",
        lambda text: text + "\x1a\r\n",
        lambda text: text + "\0" * 500,
        lambda text: text + "\n\x1a" + "\0" * 3,
        lambda text: "# take 3\n" + text,
        lambda text: "; take {3}\n// by hand\n" + text,
        lambda text: text.replace("Hips\n", "Hips // the root\n").replace("1.5 0\n", "1.5 0 # up {\n"),
        lambda text: text.replace("MOTION\n", "MOTION # 3 frames\n# at 10\n").replace("0.1\n", "0.1 ; seconds\n"),
        lambda text: text.replace("5.5 6", "# half time\n5.5 6") + "# the end\n",
        lambda text: text.encode("utf-16"),
        lambda text: text.encode("utf-16-le"),
        lambda text: text.encode("utf-16-be"),
        lambda text: b"\xfe\xff" + (text + "\0\0").encode("utf-16-be"),
        lambda text: text.encode("utf-8-sig"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace(" ", "\t").replace("Frame\tTime", "Frame Time").replace("End\tSite", "End Site"),
        lambda text: text.lower().replace("hips", "Hips").replace("chest", "Chest"),
        lambda text: text.replace("Frames: 3", "FRAMES :  3").replace("Frame Time: 0.1", "frametime:.1"),
        lambda text: text.replace("Frames: 3", "Frames 3").replace("Frame Time: 0.1", "Frame Time 1e-1"),
        lambda text: text.replace("Frames: 3\nFrame Time: 0.1\n", "Frame Time: 0.1\nFrames: 3\n"),
        lambda text: text.replace("End Site", "End site"),
        lambda text: text.replace("End Site", "EndSite"),
        lambda text: text.replace("End Site", "End"),
        lambda text: text.replace("End Site", "Site"),
        lambda text: text.replace("End Site\n    {", "End Site{").replace("Chest\n  {", "Chest{"),
        lambda text: text.replace("  }\n}\n", "} }\n"),
    ],
)
def test_small_liberties_do_not_matter(change: Callable[[str], str | bytes]) -> None:
    parsed = parse(change(SMALL))
    assert_same(parsed)
    assert not parsed.warnings
    assert not parsed.notes


def test_a_number_sign_in_a_name_is_no_comment() -> None:
    assert parse(SMALL.replace("Chest", "Bone #1")).nodes.names[1] == "Bone #1"


def tree(*names: str) -> str:
    """Returns a file whose first joint has the others as children, or as grandchildren if they begin with a dot."""
    text = f"HIERARCHY\nROOT {names[0]}\n{{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n"
    for name, following in zip(names[1:], [*names[2:], ""], strict=True):
        text += f"JOINT {name.lstrip('.')}\n{{\nOFFSET 0 1 0\n"
        text += "" if following.startswith(".") else "}\n" * (1 + name.startswith("."))
    return f"{text}}}\nMOTION\nFrames: 1\nFrame Time: 0.1\n0\n"


@pytest.mark.parametrize(
    ("names", "renamed"),
    [
        (("Hips", "Tip", "Tip", "Tip"), ("Hips", "Tip", "Tip.001", "Tip.002")),
        (("Hips", "Tip", "Tip.001", "Tip"), ("Hips", "Tip", "Tip.001", "Tip.002")),
        (("Hips", "Tip", "Tip", "Tip.001"), ("Hips", "Tip", "Tip.002", "Tip.001")),
        (("Hips", "Hips"), ("Hips", "Hips.001")),
        (("Hips", "Head", ".Head"), ("Hips", "Head", "Head.001")),  # the upper one has the role
    ],
)
def test_a_name_that_comes_twice_is_numbered_and_noted(names: tuple[str, ...], renamed: tuple[str, ...]) -> None:
    parsed = parse(tree(*names))
    assert parsed.nodes.names == renamed
    assert parsed.notes[0].startswith("renamed, because another joint has the same name: ")
    assert set(renamed) - set(names) <= set(parsed.notes[0].split(": ")[1].split(", "))
    again = parse(tree(*names))  # of a hierarchy that is remembered
    assert (again.nodes.names, again.notes) == (renamed, parsed.notes)


def test_two_joints_for_one_role_are_refused_with_both_lines() -> None:
    with pytest.raises(FormatError, match="'LeftArm', on lines 6 and 10: it is unclear which is the left shoulder"):
        parse(tree("Hips", "LeftArm", "LeftArm"))


def two_bodies(prefix: str, prop: str = "") -> bytes:
    """Returns a walk of two bodies, the second 1 m to the left, perhaps after a prop."""
    head, rows = WALK.decode().split("MOTION\n")
    joints = head.removeprefix("HIERARCHY\n")
    second = joints.replace("ROOT ", f"ROOT {prefix}").replace("JOINT ", f"JOINT {prefix}")
    header, frames = rows.split("\n", 2)[:2], rows.splitlines()[2:]
    lines = []
    for line in frames:
        x, rest = line.split(" ", 1)
        lines.append(f"{'5 ' * bool(prop)}{line} {float(x) + 100:.6f} {rest}")
    return "\n".join(["HIERARCHY", prop + joints + second + "MOTION", *header, *lines, ""]).encode()


PROP = "ROOT Camera\n{\nOFFSET 0 0 0\nCHANNELS 1 Xposition\n}\n"


@pytest.mark.parametrize(("prefix", "prop"), [("B_", ""), ("", ""), ("B_", PROP)])
def test_of_several_roots_the_first_body_is_read_or_the_one_chosen(prefix: str, prop: str) -> None:
    data, plain = two_bodies(prefix, prop), bvh.parse(WALK)
    first = bvh.parse(data)
    assert first.nodes.names == plain.nodes.names
    np.testing.assert_array_equal(first.nodes.rotations, plain.nodes.rotations)
    np.testing.assert_array_equal(first.nodes.translations[0], plain.nodes.translations[0])
    np.testing.assert_array_equal(first.nodes.end_parents, plain.nodes.end_parents)
    other = f"{prefix}Hips" if prefix else "Hips.001"
    others = f"Camera, {other}" if prop else other
    assert f"read the skeleton 'Hips'; choose another with --root: {others}" in first.notes
    for joint in (other, f"{prefix}LeftLeg") if prefix else (other,):
        second = bvh.parse(data, root=joint)
        assert second.nodes.names == (other, *second.nodes.names[1:])
        assert second.nodes.names[1:] == tuple(prefix + name for name in plain.nodes.names[1:])
        assert not any("--root" in note for note in second.notes)
        np.testing.assert_array_equal(second.nodes.parents, plain.nodes.parents)
        np.testing.assert_array_equal(second.nodes.rotations, plain.nodes.rotations)
        moved = second.nodes.translations[0] - plain.nodes.translations[0]
        np.testing.assert_allclose(moved, np.broadcast_to([100.0, 0.0, 0.0], moved.shape), atol=1e-5)
    with pytest.raises(FormatError, match=r"unknown joint 'Hipz' for --root. Did you mean 'Hips'"):
        bvh.parse(data, root="Hipz")


@given(
    st.lists(
        st.floats(-1e3, 1e3) | st.floats(-1e-6, 1e-6) | st.sampled_from([-0.0, 5.1e-9, 1e15]), min_size=3, max_size=3
    )
)
def test_offsets_are_written_as_plain_decimals(offset: list[float]) -> None:
    walk = make("walk", seconds=0.2)
    names, parents = ("a", "b"), np.array([-1, 0])
    skeleton = Skeleton(names, parents, np.array([[0.0, 0.0, 0.0], offset]), np.array([1]), np.array([offset]))
    clip = replace(walk, skeleton=skeleton, rotations=walk.rotations[:, :2])
    lines = [line.split()[1:] for line in bvh.dump_bvh(clip).decode().splitlines() if "OFFSET" in line]
    for line in lines[1:]:
        assert not any("e" in word.lower() or word == "-0" for word in line)
        np.testing.assert_allclose([float(word) for word in line], offset, rtol=1e-8, atol=1e-12)


def test_frames_are_written_without_negative_zeros() -> None:
    assert b" -0.000000" not in WALK
    assert b"e-" not in WALK.split(b"MOTION")[1]
