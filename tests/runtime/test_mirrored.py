from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.errors import ClipError, UnknownClipError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.kinematics import joint_positions
from motionsplice.motion.mirror import FLIP
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.twins import MIRROR
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.mirrored import MIRRORED, mirrored_name
from motionsplice.runtime.requests import METHODS, POSTURES
from motionsplice.runtime.splice import Splice
from tests.conftest import CLIPS
from tests.playing import RATE, Setup, evaluated
from tests.random_bank import random_bank

STATELESS = sorted(POSTURES.keys() - {"running"})


def image_of(bank: Bank, rotations: NDArray[Any]) -> Floats:
    """Returns the mirror image of local rotations [..., J, 4]."""
    assert bank.mirror is not None
    return bank.mirror.rotations(rotations.astype(np.float64), bank.skeleton.parents)


@given(st.data())
@settings(max_examples=60)
def test_the_splice_of_mirror_images_is_the_mirror_image_of_the_splice(bank: Bank, data: st.DataObject) -> None:
    locomotion, action = (data.draw(st.sampled_from(bank.clips)) for _ in range(2))
    method: Any = data.draw(st.sampled_from(sorted(METHODS)))
    posture: Any = data.draw(st.sampled_from(STATELESS))
    time, start = data.draw(st.floats(0.0, locomotion.duration)), data.draw(st.sampled_from([0.0, 0.3, 1.7]))
    splice = Splice(locomotion.name, action.name, start=start, method=method, posture=posture)
    mirrored = replace(splice, locomotion=locomotion.name + MIRRORED, action=action.name + MIRRORED)
    own, image = (Evaluator(bank).pose(one, time) for one in (splice, mirrored))
    np.testing.assert_allclose(image.root_positions, own.root_positions * MIRROR, atol=1e-6)
    assert quaternion.angle(image.rotations, image_of(bank, own.rotations)).max() < 1e-4


@given(st.data())
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_characters_with_mirrored_commands_are_mirror_images(one: Setup, bank: Bank, data: st.DataObject) -> None:
    own, image = one(), one()
    for characters, suffix in ((own, ""), (image, MIRRORED)):
        characters.add(1, "walk" + suffix)
    masks = {"left_arm": "right_arm", "right_arm": "left_arm"}
    feet = {"left_foot": "right_foot", "right_foot": "left_foot"}
    for _ in range(data.draw(st.integers(1, 4))):
        locomotion, action = (data.draw(st.sampled_from(bank.clips)).name for _ in range(2))
        mask, when = data.draw(st.sampled_from(list(col.MASKS))), data.draw(st.sampled_from(list(col.WHENS)))
        frames = data.draw(st.integers(1, 40))
        for characters, suffix in ((own, ""), (image, MIRRORED)):
            sides: Any = (masks.get(mask, mask), feet.get(when, when)) if suffix else (mask, when)
            characters.act([0], Action(action + suffix, mask=sides[0], when=sides[1]))
            characters.play([0], {locomotion + suffix: 0.7, "walk" + suffix: 0.3}, blend=0.2)
        for _ in range(frames):
            for characters in (own, image):
                characters.advance()
    (root, rotations), (image_root, image_rotations) = evaluated(own), evaluated(image)
    np.testing.assert_allclose(image_root, root * MIRROR, atol=1e-4)
    assert quaternion.angle(image_rotations, image_of(bank, rotations)).max() < 1e-3


def test_events_of_feet_change_sides(one: Setup) -> None:
    own, image = one(), one()
    own.add(1, "walk")
    image.add(1, "walk~mirror")
    pairs = {(col.LEFT_DOWN, col.RIGHT_DOWN), (col.RIGHT_UP, col.LEFT_UP), (col.RIGHT_DOWN, col.LEFT_DOWN)}
    seen = 0
    for _ in range(240):
        theirs, ours = own.advance(), image.advance()
        assert all(bool(theirs & before) == bool(ours & after) for before, after in pairs)
        seen |= theirs
    assert seen & col.LEFT_DOWN
    assert seen & col.RIGHT_UP


@pytest.mark.parametrize("name", ["walk", "turn_180", "carry_box"])
def test_what_a_bank_says_of_a_mirror_image_is_what_is_measured_on_it(bank: Bank, name: str) -> None:
    image = bank.motion(name + MIRRORED)
    positions = joint_positions(image)
    own = joint_positions(bank.motion(name))
    assert bank.mirror is not None
    np.testing.assert_allclose(positions, own[:, bank.mirror.twins] * MIRROR, atol=1e-6)
    torso, measured = bank.torso(name + MIRRORED), measure_torso(image, bank.roles)
    np.testing.assert_allclose(torso.clouds, measured.clouds, atol=1e-6)
    assert quaternion.angle(torso.frames, measured.frames).max() < 1e-5
    np.testing.assert_allclose(torso.offsets, bank.torso(name).offsets * FLIP, atol=1e-7)
    np.testing.assert_allclose(bank.posture(name), bank.posture(name + MIRRORED)[::-1] * MIRROR)


def test_hands_follow_the_mirror_image_of_their_body(hands_bank: Bank) -> None:
    evaluator, times = Evaluator(hands_bank), np.linspace(0.0, 2.0, 9)
    splice = Splice("walk", "counting", hands="counting_hands")
    mirrored = replace(splice, locomotion="walk~mirror", action="counting~mirror")
    own, image = (evaluator.sequence(one, times).rotations for one in (splice, mirrored))
    assert quaternion.angle(image, image_of(hands_bank, own)).max() < 1e-4
    bare = evaluator.sequence(replace(mirrored, hands=None), times).rotations
    assert quaternion.angle(image, bare).max() > 0.3
    laid, image_laid = (hands_bank.hand_motion("counting_hands", body) for body in ("counting", "counting~mirror"))
    joints = list(hands_bank.layout.hands.joints)
    whole = np.zeros((len(laid), hands_bank.skeleton.joint_count, 4))
    whole[:, joints] = laid
    assert quaternion.angle(image_laid, image_of(hands_bank, whole)[:, joints]).max() < 1e-9


@pytest.mark.parametrize("name", ["walk", "run", "turn_180"])
def test_a_clip_that_is_read_mirrored_agrees_with_the_mirror_image(name: str, tmp_path: Path) -> None:
    """Aligned anew, the mirrored clip has the phases, contacts and root path that the bank gives the mirror image."""
    for file in {"walk", name}:
        (tmp_path / f"{file}.bvh").write_bytes(dump_bvh(CLIPS[file]))
    (tmp_path / "image.bvh").write_bytes(dump_bvh(CLIPS[name]))
    (tmp_path / "clips.toml").write_text("[image]\nmirror = true\n")
    build_bank([tmp_path], tmp_path / "bank", baseline="walk", jobs=1)
    bank = Bank.open(tmp_path / "bank")
    apart = bank.phase("image") - bank.phase(name + MIRRORED)
    assert np.abs(apart - np.round(apart.mean())).max() < 0.08
    np.testing.assert_allclose(bank.root_path("image"), bank.root_path(name + MIRRORED), atol=5e-3)
    assert bank.contacts("image") == bank.contacts(name + MIRRORED)
    np.testing.assert_allclose(bank.posture("image"), bank.posture(name + MIRRORED), atol=1e-3)
    assert bank.neutral(name + MIRRORED) == bank.neutral(name) + MIRRORED


def test_a_mirror_image_has_no_mirror_image(bank: Bank) -> None:
    with pytest.raises(UnknownClipError, match="has no clip"):
        bank.number("walk~mirror~mirror")
    assert mirrored_name("walk~mirror") == "walk"
    assert bank.clip("walk~mirror").name == "walk~mirror"


def test_a_rig_without_a_mirror_image_says_so(bank: Bank) -> None:
    lame = Bank(bank.path, replace(bank.manifest, mirror=None), bank.tables)
    with pytest.raises(UnknownClipError, match="no mirror image"):
        lame.number("walk~mirror")
    plain, own = (Evaluator(one).pose(Splice("walk", "wave"), 1.0) for one in (bank, lame))
    np.testing.assert_array_equal(plain.rotations, own.rotations)


def test_a_file_with_the_name_of_a_mirror_image_is_refused(tmp_path: Path) -> None:
    (tmp_path / "walk~mirror.bvh").write_bytes(dump_bvh(CLIPS["walk"]))
    with pytest.raises(ClipError, match="mirror image of another"):
        build_bank([tmp_path], tmp_path / "bank", baseline=None, jobs=1)


def test_a_saved_row_with_a_mirror_image_moves_to_another_bank(one: Setup, bank: Bank) -> None:
    characters = one()
    characters.add(1, "walk~mirror")
    again = Characters(characters.stage, RATE, characters.state.copy())
    np.testing.assert_array_equal(evaluated(again)[1], evaluated(characters)[1])
    assert bank.numbered[int(characters.state[0, col.FIRST_LOCOMOTION])].name == "walk~mirror"


@pytest.mark.parametrize("table", ["stances", "lower"])
def test_infinite_numbers_of_a_bank_that_is_not_verified_are_mirrored_without_a_warning(table: str) -> None:
    random = random_bank(4, joints=9, clips=3, points=4, clouds="torso")
    bank = replace(random, tables={**random.tables, table: np.full_like(random.tables[table], np.inf)})
    Evaluator(bank)
    for name in (clip.name for clip in bank.numbered):
        bank.stance(name)
        bank.torso(name)
