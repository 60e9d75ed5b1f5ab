from __future__ import annotations

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import motionsplice
from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.clip_settings import ClipSettings
from motionsplice.motion.errors import BankError, BaselineError, ClipError, MotionError, SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job import job
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST
from motionsplice.runtime.format.tables import TABLE_FOLDER
from tests.conftest import CLIPS
from tests.glb_files import with_animation
from tests.rigs import two_bodies, z_up


def write(folder: Path, **clips: Clip) -> Path:
    folder.mkdir(exist_ok=True)
    for name, clip in clips.items():
        (folder / f"{name}.bvh").write_bytes(dump_bvh(clip))
    return folder


def files_of(bank: Path) -> dict[str, bytes]:
    """Returns the bank's manifest and tables by name."""
    files = [bank / MANIFEST, *sorted((bank / TABLE_FOLDER).iterdir())]
    return {str(file.relative_to(bank)): file.read_bytes() for file in files}


def test_same_clips_make_the_same_bytes_in_any_order_and_folder(clip_folder: Path, bank: Bank, tmp_path: Path) -> None:
    elsewhere = Path(shutil.copytree(clip_folder, tmp_path / "elsewhere"))
    files = sorted(elsewhere.glob("*.bvh"), reverse=True)
    build_bank(files, tmp_path / "bank", baseline="walk")
    assert files_of(tmp_path / "bank") == files_of(bank.path)


def test_a_clip_that_fails_is_named_and_the_others_finish(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], run=CLIPS["run"], short=CLIPS["walk"].frames(0, 10))
    write(clips, one_frame=CLIPS["walk"].frames(0, 1))
    (clips / "broken.bvh").write_bytes(b"HIERARCHY\nROOT")
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk", jobs=1)
    assert outcome.clips == ("run", "walk")
    assert set(outcome.failed) == {"broken", "short", "one_frame"}
    assert "lasts 0.000 s, too short" in str(outcome.failed["one_frame"])
    for name, error in outcome.failed.items():
        assert Path(error.file).name == f"{name}.bvh"
    assert "broken.bvh" in str(outcome.failed["broken"])
    assert "too short" in str(outcome.failed["short"])
    assert [clip.name for clip in Bank.open(tmp_path / "bank").clips] == ["run", "walk"]


def test_a_bank_of_actions_only_is_refused(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"])
    (clips / "clips.toml").write_text('[walk]\nkind = "action"\n')
    with pytest.raises(BaselineError, match=r"all clips are actions.*\. Add a plain walk"):
        build_bank([clips], tmp_path / "bank", jobs=1)


def test_progress_counts_every_clip(tmp_path: Path) -> None:
    seen: list[tuple[str, int, int]] = []
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], run=CLIPS["run"])
    build_bank([clips], tmp_path / "bank", jobs=1, progress=lambda *step: seen.append(step))
    assert seen == [("reading", 1, 2), ("reading", 2, 2), ("aligning", 1, 2), ("aligning", 2, 2)]


def test_without_a_baseline_the_most_typical_stride_is_taken(tmp_path: Path) -> None:
    walks = {f"walk{seed}": make("walk", seed=seed, seconds=4.0) for seed in (1, 2, 3)}
    clips = write(tmp_path / "clips", **walks, side_step=CLIPS["side_step"])
    assert build_bank([clips], tmp_path / "bank", jobs=1).baseline.name in walks


def test_a_failed_job_leaves_the_existing_bank_unchanged(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"])
    build_bank([clips], tmp_path / "bank", jobs=1)
    before = files_of(tmp_path / "bank")
    with pytest.raises(BaselineError):
        build_bank([clips], tmp_path / "bank", baseline="absent", jobs=1)
    assert files_of(tmp_path / "bank") == before


def test_a_changed_bank_keeps_the_previous_banks_tables_but_no_older_ones(tmp_path: Path) -> None:
    counts = []
    for number, name in enumerate(("walk", "run", "side_step")):
        clips = write(tmp_path / f"clips{number}", **{name: CLIPS[name]})
        build_bank([clips], tmp_path / "bank", jobs=1)
        counts.append(len(files_of(tmp_path / "bank")))
    assert counts[2] == counts[1] > counts[0]


def test_files_that_are_not_part_of_a_bank_stay(tmp_path: Path) -> None:
    mine = tmp_path / "bank" / "tables" / "mine.npy"
    mine.parent.mkdir(parents=True)
    mine.write_bytes(b"mine")
    build_bank([write(tmp_path / "clips", walk=CLIPS["walk"])], tmp_path / "bank")
    assert mine.read_bytes() == b"mine"


def test_partial_files_of_killed_jobs_are_removed_and_those_of_others_stay(tmp_path: Path) -> None:
    tables = tmp_path / "bank" / "tables"
    tables.mkdir(parents=True)
    killed, mine = tables / ".table.12.3", tables / ".mine.npy.56"
    for file in (killed, mine):
        file.write_bytes(b"half a table")
    build_bank([write(tmp_path / "clips", walk=CLIPS["walk"])], tmp_path / "bank")
    assert [file.exists() for file in (killed, mine)] == [False, True]


def test_performers_of_other_sizes_are_moved_to_the_banks_skeleton(tmp_path: Path) -> None:
    walk = CLIPS["walk"]
    tall = replace(walk, skeleton=walk.skeleton.scaled(1.3), root_positions=walk.root_positions * 1.3)
    clips = write(tmp_path / "clips", walk=walk, tall=tall)
    build_bank([clips], tmp_path / "bank", baseline="walk", jobs=1)
    bank = Bank.open(tmp_path / "bank")
    np.testing.assert_allclose(bank.motion("tall").root_positions, bank.motion("walk").root_positions, atol=1e-5)


def test_another_topology_without_retargeting_is_a_clear_error(tmp_path: Path) -> None:
    walk = CLIPS["walk"]
    leaf = int(walk.skeleton.end_parents[-1])
    remaining = [joint for joint in range(walk.skeleton.joint_count) if joint != leaf]
    places = {joint: number for number, joint in enumerate(remaining)}
    skeleton = replace(
        walk.skeleton,
        names=tuple(walk.skeleton.names[joint] for joint in remaining),
        parents=np.array([-1] + [places[int(walk.skeleton.parents[joint])] for joint in remaining[1:]]),
        offsets=walk.skeleton.offsets[remaining],
        end_parents=np.zeros(0, np.int64),
        end_offsets=np.zeros((0, 3)),
    )
    fewer = Clip("fewer", skeleton, walk.rate, walk.root_positions, walk.rotations[:, remaining])
    clips = write(tmp_path / "clips", walk=walk, fewer=fewer)
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk", retarget=False, jobs=1)
    assert outcome.failed["fewer"].problem.startswith("the rigs have different topologies: children of its joint")
    assert "retargeting" in str(outcome.failed["fewer"])


def test_another_bind_pose_without_retargeting_is_a_clear_error(tmp_path: Path) -> None:
    walk = CLIPS["walk"]
    bent = walk.skeleton.offsets.copy()
    elbow = walk.skeleton.index("LeftForeArm")
    bent[elbow] = [0.0, -float(np.linalg.norm(bent[elbow])), 0.0]
    other = replace(walk, skeleton=replace(walk.skeleton, offsets=bent))
    clips = write(tmp_path / "clips", walk=walk, other=other)
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk", retarget=False, jobs=1)
    assert "90 degrees" in str(outcome.failed["other"])


def test_a_baseline_without_a_cycle_is_refused(tmp_path: Path) -> None:
    walk = CLIPS["walk"]
    still = Clip(
        "still",
        walk.skeleton,
        60.0,
        np.tile(walk.root_positions[:1], (200, 1)),
        np.tile(walk.rotations[:1], (200, 1, 1)),
    )
    clips = write(tmp_path / "clips", still=still, walk=walk)
    with pytest.raises(BaselineError, match=r"'still' has no stride.*--baseline"):
        build_bank([clips], tmp_path / "bank", baseline="still", jobs=1)
    with pytest.raises(BaselineError, match="Did you mean 'still'"):
        build_bank([clips], tmp_path / "bank", baseline="stil", jobs=1)
    build_bank([clips], tmp_path / "bank", baseline="walk")
    assert "legs hardly move" in Bank.open(tmp_path / "bank").clip("still").warnings[0]
    assert not Bank.open(tmp_path / "bank").clip("walk").warnings
    (clips / "walk.bvh").unlink()
    with pytest.raises(BaselineError, match="none of the clips"):
        build_bank([clips], tmp_path / "bank", jobs=1)


@pytest.mark.parametrize(
    ("baseline", "words"),
    [
        (None, r"^none of the locomotions can be read\. broken0: .*\. broken2: .*\. And 2 more"),
        ("broken0", r"^the baseline cannot be read: .*broken0\.bvh"),
        ("brokn0", r"^the baseline 'brokn0' is not among the clips\. Did you mean 'broken0'"),
    ],
)
def test_if_no_clip_can_be_read_the_error_lists_the_reasons(tmp_path: Path, baseline: str | None, words: str) -> None:
    for number in range(5):
        (tmp_path / f"broken{number}.bvh").write_bytes(b"HIERARCHY\nROOT")
    with pytest.raises(BaselineError, match=words) as raised:
        build_bank([tmp_path], tmp_path / "bank", baseline=baseline)
    assert "stride" not in str(raised.value)


def test_two_clips_with_the_same_name_are_refused(tmp_path: Path) -> None:
    a, b = write(tmp_path / "a", walk=CLIPS["walk"]), write(tmp_path / "b", walk=CLIPS["walk"])
    with pytest.raises(ClipError, match=r"two clips are named 'walk'.*Rename"):
        build_bank([a, b], tmp_path / "bank")
    assert not (tmp_path / "bank").exists()


def test_a_name_that_is_not_unicode_is_refused(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"])
    try:
        shutil.copy(clips / "walk.bvh", os.fsdecode(os.fsencode(clips) + b"/run\xff.bvh"))
    except OSError:
        pytest.skip("this disk has no such names")
    with pytest.raises(ClipError, match=r"run\\udcff\.bvh': no clip can be named 'run\\udcff'.*not UTF-8"):
        build_bank([clips], tmp_path / "bank")


def test_a_file_in_the_place_of_the_bank_is_named(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"])
    (tmp_path / "bank").write_bytes(b"")
    with pytest.raises(
        BankError, match=r"bank: the bank cannot be written: File exists\. A file .* name another folder"
    ):
        build_bank([clips], tmp_path / "bank")


def test_nothing_to_do_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ClipError, match="no clips found"):
        build_bank([tmp_path], tmp_path / "bank")
    write(tmp_path / "below", walk=CLIPS["walk"])
    with pytest.raises(ClipError, match=rf"^{tmp_path}: no clips found\. .*; their subfolders are not searched$"):
        build_bank([tmp_path], tmp_path / "bank")
    with pytest.raises(ClipError, match="file or folder not found"):
        build_bank([tmp_path / "absent.bvh"], tmp_path / "bank")


def test_a_bank_in_place_of_clips_is_named(bank: Bank, tmp_path: Path) -> None:
    with pytest.raises(ClipError, match=r": this is a bank, not a folder of clips\. Name the folder"):
        build_bank([bank.path], tmp_path / "bank")


def test_a_skeleton_that_is_missing_is_found_before_clips_are_read(clip_folder: Path, tmp_path: Path) -> None:
    steps: list[str] = []
    with pytest.raises(MotionError, match=r"missing\.glb"):
        build_bank(
            [clip_folder],
            tmp_path / "bank",
            baseline="walk",
            skeleton=tmp_path / "missing.glb",
            progress=lambda step, *_: steps.append(step),
        )
    assert steps == []


def test_files_of_other_programs_alone_are_named_in_the_error(tmp_path: Path) -> None:
    for name in ("jog.c3d", "scene.BLEND", "16.asf", "readme.txt", "clips.toml", "skin.png"):
        (tmp_path / name).write_bytes(b"anything")
    problem = r"these cannot be read: jog\.c3d, scene\.BLEND\. Export them as BVH or GLB$"
    with pytest.raises(ClipError, match=problem):
        build_bank([tmp_path], tmp_path / "bank")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[walkk]\nkind = 'action'", "clip 'walkk' not found in its folder. Did you mean 'walk'"),
        ("[walk]\nkindd = 'action'", "unknown key 'kindd'.*Did you mean 'kind'"),
        ("[walk]\nkind = 'dance'", 'invalid value kind = \'dance\'.*Use "locomotion" or "action"'),
        ("[walk]\nskip_frames = -1", "skip_frames = -1"),
        ("[walk]\nskip_frames = true", "skip_frames = True"),
        ("[walk]\nup = 'w'", 'up = \'w\'.*Use "x", "y", "z", "-x"'),
        ("[walk]\nrate = 0", "rate = 0.*Use a number above 0"),
        ("[walk]\nrate = true", "rate = True"),
        ("[walk]\nroot = 3", "root = 3"),
        ("[walk]\nmask = 'legs'", 'mask = \'legs\'.*Use "upper_body", "left_arm"'),
        ("[walk]\nmask = ['arms']", "mask = "),
        ("[walk]\nroles = 3", "roles = 3.*Use the name of a roles file"),
        ("[walk]\nroles = 'none.toml'", "clip 'walk', none.toml: the file cannot be read"),
        ("[box:run]", 'not TOML.*Write a name with a colon in quotes, as \\["moves:run"\\]'),
        ("[walk]\ntags = 'one'", "tags"),
        ("[walk]\ntags = 5", "tags = 5"),
        ("walk = 3", r"expected a table, found 3. Begin it with \[walk\]"),
        ("[walk", "not TOML"),
    ],
)
def test_a_bad_clips_toml_is_refused(tmp_path: Path, text: str, words: str) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"])
    (clips / "clips.toml").write_text(text)
    with pytest.raises(SettingsError, match=rf"clips.toml.*{words}"):
        build_bank([clips], tmp_path / "bank")


def test_settings_are_applied_to_the_clip(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], box=CLIPS["carry_box"], run=CLIPS["run"])
    (clips / "clips.toml").write_text("[box]\nkind = 'action'\ntags = ['a', 'b']\nskip_frames = 7\nunit = 'm'\n")
    build_bank([clips], tmp_path / "bank", jobs=1)
    bank = Bank.open(tmp_path / "bank")
    assert bank.clip("box").frame_count == CLIPS["carry_box"].frame_count - 7
    assert bank.clip("box").tags == ("a", "b")
    assert bank.neutral("box") == "walk"  # nearer in gait than the run


def test_a_walk_of_less_than_two_strides_is_no_neutral(tmp_path: Path) -> None:
    short, action = make("walk", seconds=1.2, seed=3), make("walk", "carry_box", seed=3)
    clips = write(tmp_path / "clips", short=short, slow=make("slow_walk"), box=action)
    (clips / "clips.toml").write_text("[box]\nkind = 'action'\n")
    build_bank([clips], tmp_path / "bank", baseline="slow")
    assert Bank.open(tmp_path / "bank").neutral("box") == "slow"


def test_settings_hold_where_clips_toml_says_nothing_else(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], box=CLIPS["carry_box"], run=CLIPS["run"])
    (clips / "clips.toml").write_text("[box]\nkind = 'action'\n[run]\nskip_frames = 3\n")
    build_bank([clips], tmp_path / "bank", settings=ClipSettings(skip_frames=7, tags=("captured",)))
    bank = Bank.open(tmp_path / "bank")
    skipped = {
        one: clip.frame_count - bank.clip(one).frame_count
        for one, clip in (("box", CLIPS["carry_box"]), ("run", CLIPS["run"]), ("walk", CLIPS["walk"]))
    }
    assert skipped == {"box": 7, "run": 3, "walk": 7}
    assert (bank.clip("box").kind, bank.clip("box").tags) == ("action", ("captured",))


def test_axis_rate_and_root_of_a_clip_are_settings(tmp_path: Path) -> None:
    walk = CLIPS["walk"]
    clips = write(tmp_path / "clips", walk=walk, stated=two_bodies(z_up(walk), apart=1.0))
    (clips / "clips.toml").write_text(f"[stated]\nup = 'z'\nrate = {2 * walk.rate}\nroot = 'B_Hips'\n")
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk", jobs=1)
    assert not outcome.failed
    found = Bank.open(tmp_path / "bank").clip("stated")
    assert (found.rate, found.duration) == (2 * walk.rate, 0.5 * walk.duration)


def test_a_leading_bind_pose_is_a_warning_until_it_is_skipped(tmp_path: Path) -> None:
    walk = CLIPS["walk"]
    posed = walk.rotations.copy()
    posed[0] = quaternion.IDENTITY
    clips = write(tmp_path / "clips", walk=walk, posed=replace(walk, rotations=posed))
    build_bank([clips], tmp_path / "bank", baseline="walk")
    bank = Bank.open(tmp_path / "bank")
    assert any("--skip-frames 1" in warning for warning in bank.clip("posed").warnings)
    assert not bank.clip("walk").warnings
    (clips / "clips.toml").write_text("[posed]\nskip_frames = 1\n")
    build_bank([clips], tmp_path / "bank", baseline="walk")
    assert not Bank.open(tmp_path / "bank").clip("posed").warnings


def test_a_missing_neutral_fails_only_its_own_clip(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], box=CLIPS["carry_box"])
    (clips / "clips.toml").write_text("[box]\nkind = 'action'\nneutral = 'wallk'\n")
    outcome = build_bank([clips], tmp_path / "bank", jobs=1)
    assert outcome.clips == ("walk",)
    assert str(outcome.failed["box"]).startswith(f"{clips / 'box.bvh'}, clip 'box': its neutral 'wallk' is not")
    assert "Did you mean 'walk'" in str(outcome.failed["box"])


def test_real_clips_of_several_people_and_formats_share_a_bank(real_motion: Path, tmp_path: Path) -> None:
    for name in ("16.asf", "16_15.amc", "02.asf", "02_01.amc", "06_01.bvh"):
        shutil.copy(real_motion / name, tmp_path)
    (tmp_path / "clips.toml").write_text("[06_01]\nskip_frames = 1\n")
    outcome = build_bank([tmp_path], tmp_path / "bank", baseline="16_15", jobs=1)
    assert not outcome.failed, {name: str(error) for name, error in outcome.failed.items()}
    for clip in Bank.open(tmp_path / "bank").clips:
        assert clip.mean_mismatch < 0.04
        assert clip.cycles == pytest.approx(clip.duration / 1.13, rel=0.2)


def test_errors_survive_the_return_from_a_worker_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job, "WORTH_A_PROCESS", 1)
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], run=CLIPS["run"])
    (clips / "broken.bvh").write_bytes(b"\x00\xff" * 100)
    outcome = build_bank([clips], tmp_path / "bank", baseline="walk", jobs=2)
    assert isinstance(outcome.failed["broken"], MotionError)
    assert "broken.bvh" in str(outcome.failed["broken"])


def test_without_any_locomotion_the_baseline_is_the_neutral(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", box=CLIPS["carry_box"], wave=CLIPS["wave"])
    (clips / "clips.toml").write_text("[box]\nkind = 'action'\n[wave]\nkind = 'action'\n")
    build_bank([clips], tmp_path / "bank", baseline="box")
    assert Bank.open(tmp_path / "bank").neutral("wave") == "box"


def test_paths_may_be_text(tmp_path: Path) -> None:
    motionsplice.write_sample_gestures(str(tmp_path / "gestures"))
    walk = write(tmp_path / "clips", walk=CLIPS["walk"]) / "walk.bvh"
    outcome = motionsplice.build_bank(str(walk), str(tmp_path / "bank"))
    assert outcome.clips == ("walk",)
    assert motionsplice.read_clip(str(walk)).clip.name == "walk"
    assert motionsplice.Bank.open(str(tmp_path / "bank")).digest == outcome.digest


def test_each_animation_of_a_file_is_a_clip(tmp_path: Path) -> None:
    """Two animations of one skeleton in one file, beside a BVH file of the same rig."""
    walk, run = dump_glb(CLIPS["walk"]), CLIPS["run"]
    both = tmp_path / "moves.glb"
    both.write_bytes(with_animation(walk, run))
    clips = write(tmp_path / "clips", wave=CLIPS["wave"])
    both.rename(clips / "moves.glb")
    (clips / "clips.toml").write_text('[wave]\nkind = "action"\n["moves:run"]\ntags = ["fast"]\n')
    outcome = build_bank([clips], tmp_path / "bank", baseline="moves:walk")
    assert (outcome.clips, outcome.failed) == (("moves:run", "moves:walk", "wave"), {})
    bank = Bank.open(tmp_path / "bank")
    assert bank.clip("moves:run").tags == ("fast",)
    assert bank.clip("moves:run").frame_count == run.frame_count
    assert quaternion.angle(bank.motion("moves:run").rotations, run.rotations).max() < 1e-4
    assert build_bank([clips], tmp_path / "bank", baseline="moves:walk").unchanged


def test_the_settings_of_a_file_are_those_of_its_animations(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", wave=CLIPS["wave"])
    (clips / "moves.glb").write_bytes(with_animation(dump_glb(CLIPS["walk"]), CLIPS["run"]))
    (clips / "clips.toml").write_text('[moves]\ntags = ["all"]\nrate = 30\n["moves:run"]\ntags = ["fast"]\n')
    build_bank([clips], tmp_path / "bank", baseline="wave")
    bank = Bank.open(tmp_path / "bank")
    assert [(one.name, one.tags, one.rate) for one in bank.clips if one.name != "wave"] == [
        ("moves:run", ("fast",), 30.0),
        ("moves:walk", ("all",), 30.0),
    ]


def test_a_damaged_glb_fails_alone(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"])
    (clips / "clips.toml").write_text('["broken:run"]\ntags = ["fast"]\n')
    (clips / "broken.glb").write_bytes(dump_glb(CLIPS["run"])[:1000])
    outcome = build_bank([clips], tmp_path / "bank")
    assert outcome.clips == ("walk",)
    assert "broken.glb: its header says" in str(outcome.failed["broken"])
