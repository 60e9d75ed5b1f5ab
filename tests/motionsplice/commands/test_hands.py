from __future__ import annotations

import re
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from rich.console import Console
from typer.testing import CliRunner

from motionsplice.cli import app, main
from motionsplice.commands import hands as command_hands
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.hand_joints import fingers_of, wrist_of
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.procedural.hand_rig import FIST, OPEN, with_fingers
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import Roles, find_roles
from motionsplice.pictures.brush import Brush, canvas, reduced
from motionsplice.pictures.hand_figure import HandFigure
from motionsplice.pictures.sheets import contact_sheet
from motionsplice.pictures.stick_figure import GHOST, LEFT, RIGHT
from motionsplice.precompute.hands.banded_warp import FramePair
from motionsplice.precompute.hands.phases import count_phases, phases
from motionsplice.precompute.hands.points import hand_motion
from motionsplice.precompute.hands.settings import HandSettings
from motionsplice.precompute.hands.splice import splice_hands
from tests.conftest import COUNTING

ROLES = find_roles(COUNTING.truth.skeleton)


@pytest.fixture(autouse=True)
def _wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_hands, "console", Console(width=200))


def output_of(*arguments: object) -> str:
    result = CliRunner().invoke(app, ["hands", *(str(argument) for argument in arguments)])
    assert result.exit_code == 0, result.output
    return result.output


def test_hands_are_laid_on_a_body_from_files(hands_folder: Path, tmp_path: Path) -> None:
    files = hands_folder / "counting.bvh", hands_folder / "counting_hands.bvh"
    output = output_of(*files, "--out", tmp_path / "out.bvh", "--unit", "m", "--pair", "120:95~9")
    found = read_clip(tmp_path / "out.bvh", unit="m").clip
    body, hands = (read_clip(file, unit="m") for file in files)
    settings = HandSettings(pairs=(FramePair(120, 95, 9),))
    spliced = splice_hands(body.clip, body.roles, hands.clip, hands.roles, settings)
    np.testing.assert_allclose(joint_positions(found), joint_positions(spliced.clip), atol=1e-4)
    found_pair = re.search(r"pair 120:95~9: frame ([\d.]+) of the hands", output)
    assert found_pair is not None
    assert 86.0 <= float(found_pair[1]) <= 104.0
    assert f"{found.frame_count} frames at 60 per second, aligned and merged in" in output


def test_phases_of_either_performer_are_counted(hands_folder: Path, tmp_path: Path) -> None:
    files = hands_folder / "counting.bvh", hands_folder / "counting_hands.bvh"
    output = output_of(*files, "--out", tmp_path / "out.bvh", "--unit", "m", "--hand", "right")
    rows = re.findall(r"│ right │ (\S+) +│ +([\d.]+) │ +(\d+) │ +(\d+) │ +(\d+) │ +(\d+) │", output)
    assert [row[0] for row in rows] == ["counting", "counting_hands"]
    motion = hand_motion(COUNTING.body, find_roles(COUNTING.body.skeleton), "right")
    counts = count_phases(phases(motion, COUNTING.body.rate))
    assert [int(number) for number in rows[0][2:]] == [counts.get(kind, 0) for kind in command_hands.KINDS]
    assert "left" not in output


def test_the_picture_shows_bands_paths_and_pairs(hands_folder: Path, tmp_path: Path) -> None:
    pictures = []
    for number, more in enumerate(([], ["--pair", "150:100"], ["--hand", "each"])):
        file = tmp_path / f"{number}.png"
        output_of(
            hands_folder / "counting.bvh", hands_folder / "counting_hands.bvh", "--unit", "m",
            "--out", tmp_path / "out.bvh", "--picture", file, *more,
        )  # fmt: skip
        with Image.open(file) as picture:
            pictures.append(np.asarray(picture.convert("RGB")))
    plain, paired, each = pictures
    left = plain.shape[1] // 2
    assert where(plain[:, :left], RIGHT).sum() < where(paired[:, :left], RIGHT).sum()  # the pair's dot
    assert where(plain[:, :left], (230, 159, 0)).sum() > 500  # the path
    assert where(plain[:, left:], LEFT).any()
    assert each.shape[0] > plain.shape[0]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--pair", "12"], "pair '12': not a pair of frames"),
        (["--pair", "9000:3"], "pair 9000:3: frame 9000 of the body lies outside the clip"),
        (["--pair", "9:30", "--pair", "20:5"], "pair 20:5: it crosses the pair 9:30"),
        (["--pair", "100:150", "--pair", "200:100"], "pair 200:100: it crosses"),  # no emoji of ":100:"
        (["--pair", "9:30", "--pair", "9:30"], "pair 9:30: the pair 9:30 has the same frame of the body"),
        (["--pair", "9:30", "--pair", "9:40"], "pair 9:40: the pair 9:30 has the same frame of the body"),
        (["--band", "wide"], "--band: expected two numbers, found 'wide'"),
        (["--band", "0,0.1"], "bands must be above 0 and at most 1, not 0 and 0.1"),
        (["--picture", "x.gif"], "--picture x.gif: only .png can be written. End the name in .png"),
    ],
)
def test_an_error_is_one_paragraph_and_nothing_is_written(
    more: list[str],
    words: str,
    hands_folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    files = hands_folder / "counting.bvh", hands_folder / "counting_hands.bvh"
    command = ["hands", *files, "--unit", "m", "--out", tmp_path / "out.bvh", *more]
    monkeypatch.setattr(sys, "argv", ["motionsplice", *(str(one) for one in command)])
    with pytest.raises(SystemExit):
        main()
    printed = capsys.readouterr().err
    assert printed.startswith("error: ")
    assert words in printed
    assert not (tmp_path / "out.bvh").exists()


def test_a_body_of_one_frame_has_a_picture_too(hands_folder: Path, tmp_path: Path) -> None:
    body = read_clip(hands_folder / "counting.bvh", unit="m").clip
    still = tmp_path / "still.bvh"
    still.write_bytes(dump_bvh(replace(body, root_positions=body.root_positions[:1], rotations=body.rotations[:1])))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        output_of(
            still, hands_folder / "counting_hands.bvh", "--unit", "m",
            "--out", tmp_path / "out.bvh", "--picture", tmp_path / "picture.png",
        )  # fmt: skip
    assert (tmp_path / "picture.png").exists()


def test_clips_without_any_fingers_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "plain.bvh"
    file.write_bytes(dump_bvh(make("walk", seconds=1.0)))
    monkeypatch.setattr(sys, "argv", ["motionsplice", "hands", str(file), str(file), "--out", str(tmp_path / "o.bvh")])
    with pytest.raises(SystemExit):
        main()
    assert "neither the body nor the hands have fingers" in capsys.readouterr().err


def where(picture: NDArray[Any], colour: tuple[int, int, int]) -> NDArray[np.bool_]:
    return np.abs(picture.astype(int) - colour).max(axis=-1) < 4


def posed(pose: NDArray[np.float64]) -> Clip:
    """Returns the built-in humanoid with its left hand in a pose."""
    clip = make("walk", seconds=0.5)
    return with_fingers(clip, {1.0: np.tile(pose, (clip.frame_count, 1))})


def pixels(clip: Clip, roles: Roles = ROLES) -> NDArray[Any]:
    """Draws only the left hand, from its side."""
    figure = HandFigure.of(clip.skeleton, roles, "left")
    points = figure.points(clip.root_positions[:1], clip.rotations[:1])
    centred = (points - figure.middles(points, 0.0)[:, None])[0]
    stage = canvas(400, 400)
    figure.paint(Brush(stage, (200.0, 200.0), 600.0), centred[:, [2, 1, 0]])
    return np.asarray(reduced(stage))


def test_an_open_hand_covers_more_than_a_fist() -> None:
    opened, fist = (int((pixels(posed(pose)) < 250).any(axis=-1).sum()) for pose in (OPEN, FIST))
    assert opened > 1.15 * fist


def test_every_finger_is_drawn_from_the_palm_to_its_tip() -> None:
    figure = HandFigure.of(COUNTING.truth.skeleton, ROLES, "right")
    skeleton = COUNTING.truth.skeleton
    joints = [point for finger in figure.fingers for point in finger if point < skeleton.joint_count]
    assert sorted(joints) == fingers_of(skeleton, ROLES, "right")
    assert [len(finger) for finger in figure.fingers] == [4] * 5  # three joints and a tip
    for finger in figure.fingers:
        assert skeleton.parents[finger[0]] == wrist_of(ROLES, "right")


def test_a_hand_without_fingers_is_drawn_too() -> None:
    clip = make("walk", seconds=0.5)
    assert where(pixels(clip, find_roles(clip.skeleton)), LEFT).any()


def test_close_ups_follow_the_hand_and_leave_the_rest_out() -> None:
    pair = gesture_pair(5, kinds=["wave"], seconds=2.0, hand="left")
    rows = [("wave", pair.truth, ROLES)]
    left, right = (np.asarray(contact_sheet(rows, columns=4, hand=side)) for side in ("left", "right"))
    assert where(left[:-54], LEFT).sum() > 2000
    assert not where(left[:-54], RIGHT).any()
    assert where(right[:-54], RIGHT).sum() > 2000
    behind = np.asarray(contact_sheet(rows, columns=4, hand="left", ghost=pair.body))
    assert where(behind, GHOST).sum() > 100
