from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motionsplice.motion import quaternion
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.hand_joints import has_fingers
from motionsplice.precompute.hands.banded_warp import FramePair
from motionsplice.precompute.hands.settings import HandSettings, HandsOnBody, read_hand_settings
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from tests.conftest import CLIPS, COUNTING
from tests.precompute.job.test_job import files_of, write
from tests.whole_cycles import cut


def test_clips_of_hands_are_not_clips_of_the_bank(hands_bank: Bank) -> None:
    assert [clip.name for clip in hands_bank.clips] == ["counting", "run", "walk", "wave"]
    assert hands_bank.hand_clips == ("counting_hands", "other_hands")
    assert [(one.name, one.body, one.hand, one.wrist, one.rate) for one in hands_bank.hands] == [
        ("counting_hands", "counting", "both", False, 50.0),
        ("counting_hands", "run", "both", True, 50.0),
        ("other_hands", "counting", "right", False, 60.0),
    ]


def test_bodies_without_fingers_get_the_fingers_of_the_hands(hands_bank: Bank) -> None:
    assert has_fingers(hands_bank.skeleton, hands_bank.roles)
    walk, bank_walk = CLIPS["walk"], hands_bank.motion("walk")
    for name in walk.skeleton.names:
        ours, theirs = walk.rotations[:, walk.skeleton.index(name)], bank_walk.skeleton.index(name)
        assert quaternion.angle(bank_walk.rotations[:, theirs], ours).max() < 1e-3
    thumb = hands_bank.skeleton.index("LeftHandThumb2")
    assert quaternion.angle(bank_walk.rotations[:, thumb], quaternion.IDENTITY).max() < 1e-6


def test_warnings_about_hands_are_in_the_bank(hands_folder: Path, tmp_path: Path) -> None:
    """Of a bind pose as first frame, and of gestures unlike the body's; also if both results come from the cache."""
    clips = Path(shutil.copytree(hands_folder, tmp_path / "clips"))
    hands, still = COUNTING.hands, np.tile(quaternion.IDENTITY, (COUNTING.hands.skeleton.joint_count, 1))
    rotations = np.concatenate([still[None], hands.rotations])
    places = np.concatenate([hands.root_positions[:1], hands.root_positions])
    (clips / "counting_hands.bvh").write_bytes(dump_bvh(replace(hands, rotations=rotations, root_positions=places)))
    warnings = []
    for name in ("bank", "again"):
        build_bank([clips], tmp_path / name, baseline="walk", jobs=1)
        warnings.append(
            {one.body: one.warnings for one in Bank.open(tmp_path / name).hands if one.name == "counting_hands"}
        )
        shutil.copytree(tmp_path / "bank" / "cache", tmp_path / "again" / "cache", dirs_exist_ok=True)
    assert warnings[0] == warnings[1]
    for of_body in warnings[0].values():
        assert "the first frame looks like a bind pose" in of_body[0]
    assert "do not seem to match those of 'run'" in warnings[0]["run"][1]


def test_joints_that_hands_do_not_drive_keep_the_bodys_rotations(hands_bank: Bank) -> None:
    layout, body = hands_bank.layout, hands_bank.motion("counting", seam=True).rotations
    laid = hands_bank.hand_motion("other_hands", "counting")
    own = [layout.hands.joints.index(joint) for joint in (hands_bank.roles.right_elbow, hands_bank.roles.left_wrist)]
    for number in own:
        np.testing.assert_allclose(
            np.abs(np.sum(laid[:, number] * body[:, layout.hands.joints[number]], axis=1)), 1.0, atol=1e-6
        )
    left = [number for number, joint in enumerate(layout.hands.joints) if "Left" in hands_bank.skeleton.names[joint]]
    assert quaternion.angle(laid[:, left], body[:, [layout.hands.joints[number] for number in left]]).max() < 1e-6


@pytest.mark.parametrize("open_end", [False, True])
def test_hands_on_a_whole_cycle_go_on_with_its_first_frames(open_end: bool, tmp_path: Path) -> None:
    cycle = cut("walk", open_end=open_end)
    clips = write(tmp_path / "clips", cycle=cycle, hands=COUNTING.hands)
    build_bank([clips], tmp_path / "bank", hands=[HandsOnBody("cycle", "hands")], jobs=1)
    bank = Bank.open(tmp_path / "bank")
    frames, count = bank.tables["hand_frames"], cycle.frame_count
    again = 0 if open_end else 1
    np.testing.assert_allclose(frames[count:], frames[again : again + len(frames) - count])
    laid = bank.hand_motion("hands", "cycle")
    assert quaternion.angle(laid[-1], laid[again + len(frames) - count - 1]).max() < 1e-3


def test_same_files_make_the_same_bytes_and_only_changed_hands_are_laid_again(
    hands_folder: Path, hands_bank: Bank, tmp_path: Path
) -> None:
    clips, bank = Path(shutil.copytree(hands_folder, tmp_path / "clips")), tmp_path / "bank"
    seen: list[tuple[str, int, int]] = []

    def run() -> None:
        seen.clear()
        build_bank([clips], bank, baseline="walk", jobs=1, progress=lambda *step: seen.append(step))

    run()
    assert files_of(bank) == files_of(hands_bank.path)
    run()
    assert not seen
    hands = (clips / "hands.toml").read_text()
    (clips / "hands.toml").write_text(hands.replace("wrist = true", 'wrist = true\npairs = ["60:50"]'))
    run()
    assert seen == [("laying", 1, 1)]
    assert Bank.open(bank).hands[1].pairs == ("60:50",)
    assert Bank.open(bank).hand_frames("counting_hands", "run")[60] == pytest.approx(50.0, abs=0.01)
    (clips / "hands.toml").unlink()
    with pytest.raises(SettingsError, match="clip 'gone_hands' not found"):
        build_bank([clips], bank, baseline="walk", hands=[HandsOnBody.parse("run:gone_hands")])
    assert Bank.open(bank).hand_clips  # the bank before is still there


def test_hands_that_do_not_fit_fail_and_the_others_finish(hands_folder: Path, tmp_path: Path) -> None:
    clips = Path(shutil.copytree(hands_folder, tmp_path / "clips"))
    (clips / "other_hands.bvh").write_bytes(b"HIERARCHY\nROOT")
    (clips / "hands.toml").write_text(
        '[[hands]]\nbody = "run"\nhands = "counting_hands"\npairs = ["9999:3"]\n'
        '[[hands]]\nbody = "walk"\nhands = "counting_hands"\n[[hands]]\nbody = "walk"\nhands = "other_hands"\n'
    )
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk", jobs=1)
    assert set(outcome.failed) == {"other_hands", "counting_hands on run"}
    assert "pair 9999:3" in str(outcome.failed["counting_hands on run"])
    assert outcome.failed["counting_hands on run"].file == f"{clips / 'run.bvh'} with {clips / 'counting_hands.bvh'}"
    assert [(one.name, one.body) for one in Bank.open(tmp_path / "bank").hands] == [("counting_hands", "walk")]


def test_hands_without_fingers_fail(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], run=CLIPS["run"])
    outcome = build_bank([clips], tmp_path / "bank", hands=[HandsOnBody.parse("walk:run")], jobs=1)
    assert "neither the body nor the hands have fingers" in str(outcome.failed["run on walk"])
    assert outcome.clips == ("walk",)


def test_a_clip_of_hands_cannot_be_a_body(hands_folder: Path, tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="'counting_hands' is a hands clip, so it cannot be the body"):
        build_bank([hands_folder], tmp_path, hands=[HandsOnBody.parse("counting_hands:wave")])


@pytest.mark.parametrize("text", ["walk", ":", "walk:", ":hands"])
def test_text_without_body_and_hands_is_refused(text: str) -> None:
    with pytest.raises(SettingsError, match="does not name a body and its hands"):
        HandsOnBody.parse(text)


def test_every_key_of_hands_toml_is_read(tmp_path: Path) -> None:
    file = tmp_path / "hands.toml"
    file.write_text(
        '[[hands]]\nbody = "a"\nhands = "b"\nhand = "each"\nwrist = true\nturn = "trunk"\n'
        'bands = [0.5, 0.2]\npairs = ["120:95", "300:288~5"]\n[[hands]]\nbody = "c"\nhands = "b"'
    )
    settings = HandSettings("each", True, "trunk", (0.5, 0.2), (FramePair(120, 95), FramePair(300, 288, 5)))
    assert read_hand_settings(file) == [HandsOnBody("a", "b", settings), HandsOnBody("c", "b")]
    assert settings.groups == (("left",), ("right",))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hands = 3", "it must hold [[hands]] tables and nothing else"),
        ("[hands]\nbody = 'a'", "it must hold [[hands]] tables and nothing else"),
        ("[[hands]\n", "not TOML"),
        (
            "[[hands]]\nbody = 'a'",
            "hands 1: the key 'hands' is missing. Add hands = \"NAME\", the name of a hands clip",
        ),
        ("[[hands]]\nhands = 'a'", "hands 1: the key 'body' is missing"),
        (
            "[[hands]]\nbody = 'a'\nhands = 3",
            "hands 1: hands = 3 is not valid. hands must be the name of",
        ),
        (2 * "[[hands]]\nbody = 'a'\nhands = 'b'\n", "hands 2: b on a already exists, as hands 1"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\nhnad = 'left'", "unknown key 'hnad'. Did you mean 'hand' or 'hands'"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\nhand = 'third'", "hand must be one of left, right, both, each"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\nbands = [1]", "bands must be two parts of the clip"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\npairs = ['3']", "pair '3': not a pair of frames"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\npairs = [3]", "pairs must be a list of frame pairs"),
    ],
)
def test_a_bad_hands_toml_is_an_error_with_file_and_place(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "hands.toml"
    file.write_text(text)
    with pytest.raises(SettingsError) as raised:
        read_hand_settings(file)
    assert words in str(raised.value)
    assert "hands.toml" in str(raised.value)
