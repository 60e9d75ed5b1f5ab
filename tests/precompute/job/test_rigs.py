"""Banks of clips of several rigs."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.retarget import measures
from bench.retarget.kinds import KINDS
from bench.retarget.measures import Posed
from bench.retarget.rigs import on_rig
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import BankError, BaselineError, FormatError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.files import clips_in
from motionsplice.motion.formats.gltf.writer import dump_glb, dump_gltf
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.roles import LIMBS, find_roles
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.skeleton import rig_of
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.fbx_files import dump_fbx
from tests.glb_files import edited
from tests.precompute.job.test_job import files_of

WALK, RUN, BOX = make("walk", seconds=4.0), make("run", seconds=3.0), make("walk", "carry_box", seconds=4.0)


def on(kind: str, clip: Clip) -> Clip:
    return on_rig(clip, KINDS[kind])


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rigs")
    (folder / "walk.bvh").write_bytes(dump_bvh(on("Mixamo", WALK)))
    (folder / "jog.bvh").write_bytes(dump_bvh(on("Mixamo", make("run", seconds=3.0, seed=5))))
    (folder / "run.bvh").write_bytes(dump_bvh(on("LAFAN1", RUN)))
    (folder / "box.glb").write_bytes(dump_glb(on("Unreal", BOX)))
    (folder / "clips.toml").write_text('[box]\nkind = "action"\n')
    return folder


@pytest.fixture(scope="module")
def mixed(clips: Path, tmp_path_factory: pytest.TempPathFactory) -> Bank:
    out = tmp_path_factory.mktemp("mixed") / "bank"
    assert not build_bank([clips], out, baseline="walk").failed
    return Bank.open(out)


def test_clips_of_other_rigs_are_retargeted_and_say_so(mixed: Bank) -> None:
    assert mixed.skeleton.names[0] == "mixamorig:Hips"
    notes = {name: " ".join(mixed.clip(name).notes) for name in ("walk", "jog", "run", "box")}
    assert "retargeted by roles" in notes["box"]
    assert "retargeted by roles" in notes["run"]
    assert "retargeted" not in notes["walk"] + notes["jog"]


def test_a_splice_of_several_rigs_is_near_that_of_one(mixed: Bank, tmp_path: Path) -> None:
    same = tmp_path / "clips"
    same.mkdir()
    for name, clip in (("walk", WALK), ("jog", make("run", seconds=3.0, seed=5)), ("run", RUN), ("box", BOX)):
        (same / f"{name}.bvh").write_bytes(dump_bvh(on("Mixamo", clip)))
    (same / "clips.toml").write_text('[box]\nkind = "action"\n')
    build_bank([same], tmp_path / "bank", baseline="walk")
    one = Bank.open(tmp_path / "bank")
    splices = [Evaluator(bank).clip(Splice("run", "box")) for bank in (mixed, one)]
    got, want = (Posed.of(clip, mixed.roles) for clip in splices)
    assert measures.limbs(want, got) < 6.0  # degrees; timing and torso are computed from slightly other shoulders
    assert measures.turn_errors(got, want, ("hand", "forearm", "upper_arm", "thigh", "shin")) < 14.0  # half a palm


def test_the_same_rigs_are_copied_to_the_last_bit(clips: Path, mixed: Bank, tmp_path: Path) -> None:
    build_bank([clips / "walk.bvh", clips / "jog.bvh"], tmp_path / "bank", baseline="walk", retarget=False)
    plain = Bank.open(tmp_path / "bank")
    for name in ("walk", "jog"):
        np.testing.assert_array_equal(plain.motion(name).rotations, mixed.motion(name).rotations)


def test_a_change_of_retargeting_is_noticed(clips: Path, tmp_path: Path) -> None:
    assert not build_bank([clips], tmp_path, baseline="walk").failed
    assert set(build_bank([clips], tmp_path, baseline="walk", retarget=False).failed) == {"box", "run"}
    assert not build_bank([clips], tmp_path, baseline="walk").failed


def test_a_bank_may_have_another_skeleton_than_its_baseline(clips: Path, tmp_path: Path) -> None:
    character = tmp_path / "character.glb"
    character.write_bytes(dump_glb(on("VRM", WALK).frames(0, 1)))
    bones = {"left_hip": "J_Bip_L_UpperLeg"}
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk", skeleton=character)
    assert not outcome.failed
    bank = Bank.open(tmp_path / "bank")
    assert bank.skeleton.names[bank.roles.left_hip] == bones["left_hip"]
    walk = Posed.of(bank.motion("walk"), bank.roles)
    theirs = on("Mixamo", WALK)
    assert measures.limbs(Posed.of(theirs, find_roles(theirs.skeleton)), walk) < 0.01
    assert build_bank([clips], tmp_path / "bank", baseline="walk", skeleton=character).unchanged
    again = build_bank([clips], tmp_path / "bank", baseline="walk", skeleton=tmp_path / "bank")
    assert again.unchanged


def test_the_skeleton_of_a_bank_is_that_of_its_baseline(clips: Path, mixed: Bank, tmp_path: Path) -> None:
    build_bank([clips], tmp_path / "bank", baseline="walk", skeleton=mixed.path)
    assert files_of(tmp_path / "bank") == files_of(mixed.path)


def test_a_baseline_whose_bind_pose_does_not_stand_shows_how_it_stands(clips: Path, tmp_path: Path) -> None:
    build_bank([clips], tmp_path / "bank", baseline="run")
    bank = Bank.open(tmp_path / "bank")
    walk = on("Mixamo", WALK)
    later = onto_rig(walk, find_roles(walk.skeleton), rig_of(bank.path, {})).clip
    for clip in (bank.motion("walk"), later):
        got, want = Posed.of(clip, bank.roles), Posed.of(on("LAFAN1", WALK), bank.roles)
        assert measures.turn_errors(got, want, ("thigh", "shin", "arm")) < 0.5


def test_a_file_with_several_animations_gives_its_skeleton(clips: Path, tmp_path: Path) -> None:
    idle = replace(on("Unreal", WALK), name="idle")
    moves = tmp_path / "moves.gltf"
    moves.write_bytes(dump_gltf(idle))
    document = json.loads(moves.read_bytes())
    document["animations"].append(document["animations"][0] | {"name": "run"})
    moves.write_text(json.dumps(document))
    assert len(clips_in(moves)) == 2
    build_bank([clips / "walk.bvh"], tmp_path / "bank", skeleton=moves)
    assert Bank.open(tmp_path / "bank").skeleton.names == idle.skeleton.names


def test_a_skeleton_that_cannot_be_used_is_an_error(clips: Path, tmp_path: Path) -> None:
    with pytest.raises(BankError, match="not a bank"):
        build_bank([clips], tmp_path / "bank", baseline="walk", skeleton=clips)
    with pytest.raises(BaselineError, match="the baseline does not fit the skeleton"):
        build_bank([clips], tmp_path / "bank", baseline="walk", skeleton=clips / "box.glb", retarget=False)


def test_a_rig_of_unknown_names_has_a_roles_file_of_its_own(clips: Path, tmp_path: Path) -> None:
    odd = on("Mixamo", RUN)
    numbered = {name: f"bone{joint}" for joint, name in enumerate(odd.skeleton.names)}
    skeleton = replace(odd.skeleton, names=tuple(numbered.values()))
    folder = tmp_path / "clips"
    shutil.copytree(clips, folder)
    (folder / "odd.bvh").write_bytes(dump_bvh(replace(odd, skeleton=skeleton)))
    (folder / "clips.toml").write_text('[odd]\nroles = "odd.toml"\n')
    known = find_roles(odd.skeleton)
    lines = [f'{role} = "{skeleton.names[getattr(known, role)]}"' for role in LIMBS]
    (folder / "odd.toml").write_text("\n".join(("[roles]", *lines)))
    assert not build_bank([folder], tmp_path / "bank", baseline="walk").failed
    bank = Bank.open(tmp_path / "bank")
    assert bank.clip("odd").duration == pytest.approx(RUN.duration)
    assert "retargeted" not in " ".join(bank.clip("odd").notes)  # its tree is that of the other Mixamo clips
    (folder / "clips.toml").unlink()
    outcome = build_bank([folder], tmp_path / "bank", baseline="walk")
    assert set(outcome.failed) == {"odd"}
    assert "as `roles` of this clip in clips.toml" in str(outcome.failed["odd"])


@pytest.mark.parametrize("kind", ["glb", "fbx"])
def test_a_character_without_a_motion_gives_its_rig(kind: str, tmp_path: Path) -> None:
    if kind == "fbx":
        pytest.importorskip("ufbx")
    clip = on("Unreal", WALK)
    file = tmp_path / f"hero.{kind}"
    still = (
        dump_fbx([clip.frames(0, 1)]).replace(b"AnimationStack: ", b"Nothing: ") if kind == "fbx" else dump_glb(clip)
    )
    file.write_bytes(still if kind == "fbx" else edited(still, lambda document: document.pop("animations")))
    with pytest.raises(FormatError, match="no animation"):
        read_clip(file)
    rig = rig_of(file, {})
    assert rig.skeleton.names == clip.skeleton.names
    np.testing.assert_allclose(rig.skeleton.offsets[1:], clip.skeleton.offsets[1:], atol=1e-5)
