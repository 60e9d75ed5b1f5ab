"""The offline job on actions that stand and walk by turns."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from motionsplice.motion.procedural.gestures import gesture_pair
from motionsplice.motion.procedural.hand_rig import with_fingers
from motionsplice.motion.procedural.joined import joined
from motionsplice.motion.procedural.library import make
from motionsplice.motion.procedural.stances import Performer, standing_action
from motionsplice.precompute.hands.settings import HandsOnBody
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.conftest import written

WALK = make("walk", seconds=4.0)
HAIL = standing_action("hail", Performer())
TALK = joined("talk", [HAIL, WALK])
ACTION = '[talk]\nkind = "action"\n'


def test_an_unchanged_folder_gives_the_same_bank_again(tmp_path: Path) -> None:
    clips = written(tmp_path, {"walk": WALK, "talk": TALK}, ACTION)
    first, again = (build_bank([clips], tmp_path / "bank") for _ in range(2))
    assert first.clips == ("talk", "talk~1", "talk~2", "walk")
    assert again.unchanged
    assert (again.digest, again.reused) == (first.digest, 4)


def test_a_hybrid_locomotion_is_not_cut(tmp_path: Path) -> None:
    outcome = build_bank([written(tmp_path, {"walk": WALK, "talk": TALK}, "")], tmp_path / "bank", baseline="walk")
    assert outcome.clips == ("talk", "walk")


def test_a_clip_with_the_name_of_a_stretch_fails_the_hybrid(tmp_path: Path) -> None:
    clips = written(tmp_path, {"walk": WALK, "talk": TALK, "talk~2": WALK}, ACTION)
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk")
    assert outcome.clips == ("talk~2", "walk")
    assert "its stretch 'talk~2' has the name of another clip" in str(outcome.failed["talk"])
    assert outcome.failed["talk"].file == str(clips / "talk.bvh")


def test_a_neutral_is_that_of_the_stretches_that_stand_or_walk_as_it_does(tmp_path: Path) -> None:
    clips = {"walk": WALK, "other": make("walk", seed=5, seconds=4.0), "idle": HAIL.frames(0, 60), "talk": TALK}
    for neutral, expected in (("idle", ["idle", "walk"]), ("other", ["talk~1", "other"])):
        settings = f'[talk]\nkind = "action"\nneutral = "{neutral}"\n[idle]\nkind = "action"'
        folder = tmp_path / neutral
        folder.mkdir()
        assert not build_bank([written(folder, clips, settings)], folder / "bank", baseline="walk").failed
        assert [Bank.open(folder / "bank").neutral(name) for name in ("talk~1", "talk~2")] == expected


def test_hands_on_a_hybrid_are_on_its_stretches_too(tmp_path: Path) -> None:
    pair = gesture_pair(3, kinds=["count", "point"], seconds=4.5, locomotion=None)
    clips = {"walk": WALK, "talk": joined("talk", [pair.body, with_fingers(WALK)]), "fingers": pair.hands}
    build_bank(
        [written(tmp_path, clips, ACTION)], tmp_path / "bank", baseline="walk", hands=[HandsOnBody("talk", "fingers")]
    )
    bank = Bank.open(tmp_path / "bank")
    assert [one.body for one in bank.hands] == ["talk", "talk~1", "talk~2"]
    first = bank.clip("talk~1")
    whole, part = (bank.hand_motion("fingers", name) for name in ("talk", "talk~1"))
    np.testing.assert_allclose(np.abs(part[: first.frame_count]), np.abs(whole[: first.frame_count]), atol=1e-6)
    evaluator = Evaluator(bank)
    worn, bare = (evaluator.sequence(Splice("walk", "talk", hands=hands), [1.5, 3.0]) for hands in ("fingers", None))
    assert np.abs(worn.rotations - bare.rotations).max() > 0.1
