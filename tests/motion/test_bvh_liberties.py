"""More peculiarities of BVH files: encodings, headers, and what stands before or between the numbers."""

from __future__ import annotations

import pytest

from motionsplice.motion.errors import FormatError
from tests.motion.test_bvh_field import ROWS, SMALL, assert_same, parse

JAPANESE = SMALL.replace("Hips", "センター").replace("Chest", "左足")
CHINESE = SMALL.replace("Hips", "骨盆").replace("Chest", "右大腿")


@pytest.mark.parametrize(
    ("text", "encoding"),
    [(JAPANESE, "cp932"), (CHINESE, "gb18030"), (JAPANESE, "utf-16"), (SMALL.replace("Hips", "Hüfte…"), "cp1252")],
)
def test_names_keep_their_letters_in_older_encodings(text: str, encoding: str) -> None:
    parsed = parse(text.encode(encoding))
    assert parsed.nodes.names == parse(text).nodes.names
    assert parsed.rate == parse(text).rate


@pytest.mark.parametrize("comment", ["/* take 3\n by hand */", "% MATLAB", "-- ROOT", "REM take 3"])
def test_what_precedes_the_first_word_is_left_out_with_a_note(comment: str) -> None:
    parsed = parse(f"{comment}\n{SMALL}")
    assert_same(parsed)
    assert parsed.notes[0].startswith(f"left out what precedes HIERARCHY: '{comment.splitlines()[0]}")
    with pytest.raises(FormatError, match="line 1: expected HIERARCHY"):
        parse(f"{comment}\n{SMALL.removeprefix('HIERARCHY')}")


@pytest.mark.parametrize(
    "header",
    [
        "Frames: 3 Frame Time: 0.1",
        "Frames = 3\nFrame Time = 0.1",
        "frames=3\nframe_time=0.1",
        "Frame Time: 0.1 Frames: 3",
    ],
)
def test_the_header_may_be_written_in_other_ways(header: str) -> None:
    parsed = parse(SMALL.replace("Frames: 3\nFrame Time: 0.1", header))
    assert_same(parsed)
    assert not parsed.warnings


@pytest.mark.parametrize("header", ["Frames: 3 Rate: 10", "Frames: 3 Frame Time:", "Frames: 3 4\nFrame Time: 0.1"])
def test_a_header_with_anything_else_is_refused_with_the_line(header: str) -> None:
    with pytest.raises(FormatError, match="line 17: expected 'Frames: N' and 'Frame Time: seconds', found 'Frames: 3"):
        parse(SMALL.replace("Frames: 3\nFrame Time: 0.1", header))


@pytest.mark.parametrize("comma", [", ", ",", " , "])
def test_commas_may_separate_numbers(comma: str) -> None:
    text = SMALL.replace("OFFSET 0.25 0.5 0", f"OFFSET 0.25{comma}0.5{comma}0")
    for row in ROWS:
        text = text.replace(row, row.replace(" ", comma))
    parsed = parse(text)
    assert_same(parsed)
    assert not parsed.notes
    assert_same(parse(SMALL.replace(ROWS[0], ROWS[0].replace(" ", comma) + ",")))


def test_too_many_values_are_not_called_cut_short() -> None:
    with pytest.raises(FormatError) as error:
        parse(SMALL.replace("4\n5.5", "4 0\n5.5").replace("8\n", "8 0\n"))
    assert "line 19, frame 0: expected 4 values per frame, found 5" in str(error.value)
    assert "for its 4 channels only" in str(error.value)
