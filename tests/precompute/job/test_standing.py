"""Standing actions in the offline job: which clips they are, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import msgpack
import numpy as np
import pytest

from motionsplice.motion.errors import BankError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.parts import PARTS
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST, content_digest
from tests.conftest import STANDING_CLIPS


def built(folder: Path, settings: str, *names: str) -> Bank:
    """Builds a bank of the walk and of standing clips. All must succeed."""
    clips = folder / "clips"
    clips.mkdir(exist_ok=True)
    for name in ("walk", *names):
        (clips / f"{name}.bvh").write_bytes(dump_bvh(STANDING_CLIPS[name]))
    (clips / "clips.toml").write_text(settings)
    outcome = build_bank([clips], folder / "bank", baseline="walk")
    assert not outcome.failed
    return Bank.open(folder / "bank")


def test_an_action_without_a_gait_is_said_to_stand_and_is_its_own_neutral(standing_bank: Bank) -> None:
    hail = standing_bank.clip("hail")
    assert hail.stands
    assert not hail.gait
    assert hail.warnings == ()
    assert "stands, so it plays at its own speed; it uses right arm" in hail.notes
    assert standing_bank.neutral("hail") == "hail"
    assert [clip.name for clip in standing_bank.clips if not clip.stands] == ["idle", "run", "walk"]
    assert standing_bank.standing("walk") is None


def test_a_named_idle_is_the_neutral(standing_bank: Bank) -> None:
    standing, idle = standing_bank.standing("jab"), standing_bank.motion("idle").rotations
    assert standing_bank.neutral("jab") == "idle"
    assert standing is not None
    upper = standing_bank.skeleton.subtree(standing_bank.roles.pelvis)
    mean = idle[:, upper].mean(axis=0)
    np.testing.assert_allclose(standing.stance[upper], mean / np.linalg.norm(mean, axis=-1, keepdims=True), atol=1e-5)


def test_a_walk_is_never_the_neutral_of_a_standing_action(standing_bank: Bank) -> None:
    assert standing_bank.neutral("bow") == "bow"
    assert standing_bank.clip("bow").warnings == (
        "stands, so 'walk', which walks, cannot be its neutral; its own frames at rest are used",
    )


def test_an_idle_as_neutral_makes_an_action_with_steps_a_standing_one(tmp_path: Path) -> None:
    settings = "[walk_on]\nkind = 'action'\nneutral = 'idle'\n"
    clips = tmp_path / "clips"
    clips.mkdir()
    (clips / "walk_on.bvh").write_bytes(dump_bvh(make("walk", "wave", seed=3, seconds=3.0)))
    bank = built(tmp_path, settings, "idle")
    assert bank.clip("walk_on").gait
    assert bank.clip("walk_on").stands


def test_a_changed_mask_only_writes_the_tables_anew(tmp_path: Path) -> None:
    bank = built(tmp_path, "[hail]\nkind = 'action'\n", "hail")
    assert bank.clip("hail").parts == (1 << PARTS) - 1
    (tmp_path / "clips" / "clips.toml").write_text("[hail]\nkind = 'action'\nmask = 'left_arm'\n")
    outcome = build_bank([tmp_path / "clips"], tmp_path / "bank", baseline="walk")
    assert (outcome.reused, outcome.unchanged) == (2, False)
    assert Bank.open(tmp_path / "bank").clip("hail").uses == ("left arm",)


def test_a_mask_without_effect_is_a_warning(tmp_path: Path) -> None:
    bank = built(tmp_path, "[walk]\nmask = 'arms'\n")
    assert "its mask is not used: it is no action without a gait" in bank.clip("walk").warnings


def test_a_damaged_stance_is_refused(tmp_path: Path) -> None:
    bank = built(tmp_path, "[hail]\nkind = 'action'\n", "hail")
    for field, value in (("stance", 1), ("stance", -2), ("parts", 16)):
        body = msgpack.unpackb(msgpack.unpackb(bank.manifest.data)["body"])
        body["clips"][0][field] = value
        packed = msgpack.packb(body)
        outer = msgpack.unpackb(bank.manifest.data) | {"body": packed, "digest": content_digest(packed)}
        (bank.path / MANIFEST).write_bytes(msgpack.packb(outer))
        with pytest.raises(BankError, match=r"'hail' does not match the tables|expected float32"):
            Bank.open(bank.path)


def test_clips_with_a_gait_have_no_usage(standing_bank: Bank) -> None:
    upper = standing_bank.tables["upper"]
    for clip in standing_bank.clips:
        usage = standing_bank.layout.usage(upper[clip.first_row : clip.first_row + clip.row_count])
        assert (usage.max() > 0.0) == clip.stands
