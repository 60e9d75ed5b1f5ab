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


def test_clips_of_hands_are_no_clips_of_the_bank(hands_bank: Bank) -> None:
    assert [clip.name for clip in hands_bank.clips] == ["counting", "run", "walk", "wave"]
    assert hands_bank.hand_clips == ("counting_hands", "other_hands")
    assert [(one.name, one.body, one.hand, one.wrist, one.rate) for one in hands_bank.hands] == [
        ("counting_hands", "counting", "both", False, 50.0),
        ("counting_hands", "run", "both", True, 50.0),
        ("other_hands", "counting", "right", False, 60.0),
    ]


def test_a_bank_of_bodies_without_fingers_has_those_of_the_hands(hands_bank: Bank) -> None:
    assert has_fingers(hands_bank.skeleton, hands_bank.roles)
    walk, bank_walk = CLIPS["walk"], hands_bank.motion("walk")
    for name in walk.skeleton.names:
        ours, theirs = walk.rotations[:, walk.skeleton.index(name)], bank_walk.skeleton.index(name)
        assert quaternion.angle(bank_walk.rotations[:, theirs], ours).max() < 1e-3
    thumb = hands_bank.skeleton.index("LeftHandThumb2")
    assert quaternion.angle(bank_walk.rotations[:, thumb], quaternion.IDENTITY).max() < 1e-6


def test_what_is_to_be_said_of_hands_is_in_the_bank(hands_folder: Path, tmp_path: Path) -> None:
    """A first frame that is no motion, and gestures that are not the body's; also where both come from the cache."""
    clips = Path(shutil.copytree(hands_folder, tmp_path / "clips"))
    hands, still = COUNTING.hands, np.tile(quaternion.IDENTITY, (COUNTING.hands.skeleton.joint_count, 1))
    rotations = np.concatenate([still[None], hands.rotations])
    places = np.concatenate([hands.root_positions[:1], hands.root_positions])
    (clips / "counting_hands.bvh").write_bytes(dump_bvh(replace(hands, rotations=rotations, root_positions=places)))
    said = []
    for name in ("bank", "again"):
        build_bank([clips], tmp_path / name, baseline="walk", jobs=1)
        said.append(
            {one.body: one.warnings for one in Bank.open(tmp_path / name).hands if one.name == "counting_hands"}
        )
        shutil.copytree(tmp_path / "bank" / "cache", tmp_path / "again" / "cache", dirs_exist_ok=True)
    assert said[0] == said[1]
    for warnings in said[0].values():
        assert "the first frame looks like a bind pose" in warnings[0]
    assert "hardly seem to be those of 'run'" in said[0]["run"][1]


def test_what_hands_do_not_drive_is_the_body_to_the_last_bit(hands_bank: Bank) -> None:
    layout, body = hands_bank.layout, hands_bank.motion("counting", seam=True).rotations
    laid = hands_bank.hand_motion("other_hands", "counting")
    own = [layout.hands.joints.index(joint) for joint in (hands_bank.roles.right_elbow, hands_bank.roles.left_wrist)]
    for number in own:
        np.testing.assert_allclose(
            np.abs(np.sum(laid[:, number] * body[:, layout.hands.joints[number]], axis=1)), 1.0, atol=1e-6
        )
    left = [number for number, joint in enumerate(layout.hands.joints) if "Left" in hands_bank.skeleton.names[joint]]
    assert quaternion.angle(laid[:, left], body[:, [layout.hands.joints[number] for number in left]]).max() < 1e-6


def test_same_files_make_the_same_bytes_and_only_what_changed_is_laid_anew(
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
    with pytest.raises(SettingsError, match="there is no clip 'gone_hands'"):
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
    assert [(one.name, one.body) for one in Bank.open(tmp_path / "bank").hands] == [("counting_hands", "walk")]


def test_hands_without_fingers_fail(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], run=CLIPS["run"])
    outcome = build_bank([clips], tmp_path / "bank", hands=[HandsOnBody.parse("walk:run")], jobs=1)
    assert "neither the body nor the hands have fingers" in str(outcome.failed["run on walk"])
    assert outcome.clips == ("walk",)


def test_a_clip_of_hands_has_no_hands_of_others(hands_folder: Path, tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="'counting_hands' is a clip of hands, and cannot be the body"):
        build_bank([hands_folder], tmp_path, hands=[HandsOnBody.parse("counting_hands:wave")])


@pytest.mark.parametrize("text", ["walk", ":", "walk:", ":hands"])
def test_what_names_no_body_and_hands_is_refused(text: str) -> None:
    with pytest.raises(SettingsError, match="names no body and its hands"):
        HandsOnBody.parse(text)


def test_all_that_hands_toml_says_is_read(tmp_path: Path) -> None:
    file = tmp_path / "hands.toml"
    file.write_text(
        '[[hands]]\nbody = "a"\nhands = "b"\nhand = "each"\nwrist = true\nturn = "trunk"\n'
        'bands = [0.5, 0.2]\npairs = ["120:95", "300:288~5"]\n[[hands]]\nbody = "c"\nhands = "b"'
    )
    said = HandSettings("each", True, "trunk", (0.5, 0.2), (FramePair(120, 95), FramePair(300, 288, 5)))
    assert read_hand_settings(file) == [HandsOnBody("a", "b", said), HandsOnBody("c", "b")]
    assert said.groups == (("left",), ("right",))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hands = 3", "needs tables called hands"),
        ("[hands]\nbody = 'a'", "needs tables called hands"),
        ("[[hands]\n", "not TOML"),
        ("[[hands]]\nbody = 'a'", "hands 1: it has no key 'hands'. Write hands = \"NAME\", the name of a clip"),
        ("[[hands]]\nhands = 'a'", "hands 1: it has no key 'body'"),
        ("[[hands]]\nbody = 'a'\nhands = 3", "hands 1: hands = 3 means nothing"),
        (2 * "[[hands]]\nbody = 'a'\nhands = 'b'\n", "hands 2: b on a is there already, as hands 1"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\nhnad = 'left'", "unknown key 'hnad'. Did you mean 'hand' or 'hands'"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\nhand = 'third'", "hand: one of left, right, both, each"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\nbands = [1]", "bands: two parts of 1"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\npairs = ['3']", "pair '3': it is no pair of frames"),
        ("[[hands]]\nbody = 'a'\nhands = 'b'\npairs = [3]", "pairs = "),
    ],
)
def test_a_bad_hands_toml_names_file_place_and_mend(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "hands.toml"
    file.write_text(text)
    with pytest.raises(SettingsError) as raised:
        read_hand_settings(file)
    assert said in str(raised.value)
    assert "hands.toml" in str(raised.value)
