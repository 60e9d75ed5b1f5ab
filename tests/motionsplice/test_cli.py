from __future__ import annotations

import json
import os
import re
import shutil
import socket
import subprocess
import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner, Result

import motionsplice
from motionsplice.cli import COMMANDS, _load, app, main
from motionsplice.commands import demo, motion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.kinematics import joint_positions
from motionsplice.precompute.hands.settings import read_hand_settings
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Method, Posture
from motionsplice.runtime.splice import Splice
from motionsplice.service.settings import Settings
from tests.conftest import CLIPS, STANDING_CLIPS, built, written

ROOT = Path(__file__).parents[2]
HEAVY = {"numba", "llvmlite", "scipy", "matplotlib", "PIL", "fastapi", "uvicorn"}


def run(*arguments: object) -> Result:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], terminal_width=200)
    assert result.exit_code == 0, result.output
    return result


def failure(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Runs a command that exits with 1. Returns what it prints to standard error."""
    monkeypatch.setattr(sys, "argv", ["motionsplice", *(str(argument) for argument in arguments)])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 1
    printed = capsys.readouterr().err
    assert "Traceback" not in printed
    assert printed.startswith("error: ")
    return printed


def imported(*arguments: object) -> tuple[int, str, set[str]]:
    """Runs a command in a new process. Returns its status, what it prints to standard error, and its top packages."""
    script = (
        "import json, sys\n"
        "from motionsplice.cli import main\n"
        "try:\n    main()\n"
        "finally:\n    print('\\n' + json.dumps(sorted({name.partition('.')[0] for name in sys.modules})))\n"
    )
    command = [sys.executable, "-c", script, *(str(argument) for argument in arguments)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr, set(json.loads(done.stdout.splitlines()[-1]))


def test_help_imports_no_heavy_package() -> None:
    status, _, packages = imported("--help")
    assert status == 0
    assert not packages & (HEAVY | {"numpy"})


def test_an_unknown_clip_is_reported_before_heavy_packages_are_imported(bank: Bank, tmp_path: Path) -> None:
    splice = ["splice", bank.path, "--out", tmp_path / "out.bvh"]
    for names in (["--locomotion", "nope", "--action", "wave"], ["--locomotion", "walk", "--action", "nope"]):
        status, printed, packages = imported(*splice, *names)
        assert (status, "the bank has no clip 'nope'" in printed) == (1, True)
        assert not packages & HEAVY


def test_inspect_does_not_import_the_offline_job(bank: Bank) -> None:
    status, _, packages = imported("inspect", bank.path)
    assert status == 0
    assert not packages & {"numba", "scipy", "matplotlib", "fastapi"}


@pytest.mark.parametrize(("asked", "threads"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_the_offline_job_has_one_thread_for_blas_unless_the_user_asks_for_more(
    asked: dict[str, str], threads: str
) -> None:
    code = """
import os, sys
from motionsplice.cli import _load
assert "numpy" not in sys.modules
_load("precompute")
print("numpy" in sys.modules, os.environ["OPENBLAS_NUM_THREADS"])
"""
    others = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=others | asked, capture_output=True, text=True)
    assert done.stdout.split() == ["True", threads], done.stderr


@pytest.mark.parametrize("bank", ["demo/bank", "memory://bank"])
def test_serve_says_that_it_does_not_run_on_windows(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], bank: str
) -> None:
    monkeypatch.setitem(sys.modules, "fcntl", None)
    assert failure(monkeypatch, capsys, "serve", bank) == (
        "error: the service does not run on Windows. Run it in WSL, or in the container\n"
    )


def test_serve_refuses_a_folder_of_clips_that_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], bank: Bank, tmp_path: Path
) -> None:
    printed = failure(monkeypatch, capsys, "serve", bank.path, "--clips", tmp_path / "nowhere")
    assert printed == f"error: --clips {tmp_path}/nowhere: the folder of clips was not found. Create it\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_the_list_of_commands_shows_the_first_line_of_each_help(command: str) -> None:
    assert _load(command).help.splitlines()[0] == COMMANDS[command][1]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example(command: str) -> None:
    assert f"Example: motionsplice {command}" in run(command, "--help").output


def test_the_command_has_every_posture_and_method() -> None:
    assert {posture.value for posture in motion.Posture} == set(get_args(Posture))
    assert set(motion.RUN_TIME_METHODS.values()) == set(get_args(Method))


def test_version_is_printed_and_is_an_option_of_the_help() -> None:
    assert run("--version").output == f"motionsplice {motionsplice.__version__}\n"
    assert "--version" in run("--help").output


def test_precompute_lists_the_clips_of_the_bank(clip_folder: Path, tmp_path: Path) -> None:
    output = run("precompute", clip_folder, "--out", tmp_path / "bank", "--baseline", "walk", "--jobs", 1).output
    for clip in Bank.open(tmp_path / "bank").clips:
        assert clip.name in output


def test_precompute_prints_how_many_clips_were_reused(clip_folder: Path, tmp_path: Path) -> None:
    arguments = ["precompute", clip_folder, "--out", tmp_path / "bank", "--jobs", 1]
    assert "7 clips, 0 reused\n" in run(*arguments).output
    again = run(*arguments).output
    assert again.replace("\n", "").endswith("bank: nothing to do, none of its 7 clips changed")
    assert "reading" not in again
    longer = tmp_path / "longer.bvh"
    longer.write_bytes((clip_folder / "walk.bvh").read_bytes() + b"\n")
    assert "8 clips, 7 reused\n" in run(*arguments, longer).output


def test_the_automatic_baseline_can_be_requested_by_name(clip_folder: Path, tmp_path: Path) -> None:
    run("precompute", clip_folder, "--out", tmp_path / "asked", "--baseline", "auto", "--jobs", 1)
    run("precompute", clip_folder, "--out", tmp_path / "unsaid", "--jobs", 1)
    assert Bank.open(tmp_path / "asked").digest == Bank.open(tmp_path / "unsaid").digest


def test_a_clip_that_fails_is_named_and_the_exit_status_is_1(clip_folder: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.bvh"
    broken.write_bytes(b"not a motion file")
    arguments = ["precompute", str(clip_folder), str(broken), "--out", str(tmp_path / "bank"), "--jobs", "1"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 1
    assert "broken failed" in result.stderr
    assert "aligning" in result.stderr
    assert result.stdout.startswith("7 clips, 0 reused, 1 failed\n")
    assert len(Bank.open(tmp_path / "bank").clips) == 7


def test_files_of_other_programs_in_a_folder_are_named(clip_folder: Path, tmp_path: Path) -> None:
    for name in ("jog.c3d", "notes.txt"):
        (tmp_path / name).write_bytes(b"anything")
    arguments = ["precompute", str(clip_folder), str(tmp_path), "--out", str(tmp_path / "bank"), "--jobs", "1"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0
    assert "left out, cannot be read: jog.c3d. Export them as BVH or GLB" in result.stderr
    assert "notes.txt" not in result.output


def test_subfolders_with_clips_are_named_unless_they_are_given(clip_folder: Path, tmp_path: Path) -> None:
    clips, more = tmp_path / "clips", tmp_path / "clips" / "more"
    more.mkdir(parents=True)
    (clips / "empty").mkdir()
    shutil.copy(clip_folder / "run.bvh", clips)
    shutil.copy(clip_folder / "walk.bvh", more)
    said = f"left out, subfolders are not searched: {more}. Name them too"
    assert said in run("precompute", clips, "--out", tmp_path / "bank", "--baseline", "run", "--jobs", 1).stderr
    assert said not in run("precompute", clips, more, "--out", tmp_path / "bank", "--baseline", "run").stderr


def test_inspect_lists_hands_and_warns_of_those_that_hardly_fit(hands_bank: Bank) -> None:
    output = run("inspect", hands_bank.path).output
    fit = {(one.name, one.body): one.mismatch for one in hands_bank.hands}
    assert fit["counting_hands", "counting"] < 0.4 < fit["counting_hands", "run"]
    assert f"{fit['counting_hands', 'counting']:.2f}" in output
    assert "counting_hands: its gestures do not seem to match those of 'run'" in output


def test_inspect_shows_clips_and_their_alignment(bank: Bank) -> None:
    output = run("inspect", bank.path).output
    for clip in bank.clips:
        assert clip.name in output
        assert f"{clip.cycles:.2f}" in output


@pytest.mark.parametrize("method", ["splice", "naive", "exact", "none"])
@pytest.mark.parametrize("posture", ["relative", "absolute", "off"])
def test_splice_writes_the_motion(bank: Bank, tmp_path: Path, method: str, posture: str) -> None:
    out = tmp_path / "out.bvh"
    run(*f"splice {bank.path} --locomotion walk --action carry_box --out {out} --method {method}".split(),
        "--posture", posture)  # fmt: skip
    clip = read_clip(out, unit="m").clip
    if method != "exact":
        expected = Evaluator(bank).clip(Splice("walk", "carry_box", method=method, posture=posture))  # type: ignore[arg-type]
        np.testing.assert_allclose(joint_positions(clip), joint_positions(expected), atol=1e-4)
    else:
        assert 0.5 * bank.clip("walk").frame_count < clip.frame_count <= bank.clip("walk").frame_count


def test_a_splice_shorter_than_its_locomotion_is_reported(bank: Bank, tmp_path: Path) -> None:
    splice = f"splice {bank.path} --locomotion walk --action wave --out {tmp_path / 'out.bvh'} --method".split()
    shorter = f"{bank.clip('walk').duration:.2f} s"
    assert f" s of {shorter}" in run(*splice, "exact").output
    assert f", {shorter}\n" in run(*splice, "splice").output


def test_inspect_says_which_phases_are_uneven(tmp_path: Path) -> None:
    walk, frames = CLIPS["walk"], np.arange(301.0)
    warped = walk.sampled(np.minimum(frames + 25.0 * np.sin(frames / 40.0), 300.0))
    uneven = Clip("uneven", walk.skeleton, walk.rate, *warped)
    bank = built(written(tmp_path, {"walk": walk, "uneven": uneven}, ""), tmp_path / "bank")
    (line,) = (line for line in run("inspect", bank.path).output.splitlines() if "its mean pace" in line)
    assert re.match(r"uneven: its phase runs at 0\.\d to 1\.\d times its mean pace", line)


def test_render_draws_sheets_and_animations(clip_folder: Path, tmp_path: Path) -> None:
    motions = [clip_folder / "walk.bvh", clip_folder / "run.bvh"]
    run("render", *motions, "--out", tmp_path / "sheet.png", "--columns", 4)
    run("render", clip_folder / "wave.bvh", "--out", tmp_path / "film.gif", "--view", "side")
    with Image.open(tmp_path / "sheet.png") as sheet, Image.open(tmp_path / "film.gif") as film:
        assert sheet.width >= 1200
        assert film.n_frames > 20  # type: ignore[attr-defined]


def test_demo_does_everything_but_serve(tmp_path: Path) -> None:
    output = run("demo", tmp_path).output
    for kind in ("bvh", "png", "gif"):
        assert (tmp_path / f"curve+carry_cup.{kind}").stat().st_size > 1000
    assert read_clip(tmp_path / "count_steps+hands.bvh").clip.skeleton.joint_count == 52
    assert "http://127.0.0.1:8000" in output
    assert Bank.open(tmp_path / "bank").clip("carry_box").kind == "action"
    entries = read_hand_settings(tmp_path / "gestures" / "hands.toml")
    assert {one.label: one.settings.hand for one in entries} == {
        "count_steps_hands on count_steps": "right",
        "directions_hands on directions": "both",
    }


def test_demo_names_a_command_that_serves_if_its_port_is_taken(bank: Bank) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(SettingsError) as error:
        demo.serve(bank.path, Settings(port=taken.getsockname()[1]))
    assert f"`motionsplice serve {bank.path} --port 0`" in str(error.value)
    assert "--host" not in str(error.value)


@pytest.mark.parametrize("name", ["out.fbx", "out.BVHX", "out"])
def test_other_suffixes_are_refused_before_a_file_is_read(
    bank: Bank, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    out, absent = tmp_path / name, tmp_path / "absent"
    for command in (
        ["splice", bank.path, "--locomotion", "walk", "--action", "wave"],
        ["splice", absent, "--locomotion", "walk", "--action", "wave"],
        ["hands", absent, absent],
    ):
        printed = failure(monkeypatch, capsys, *command, "--out", out)
        assert f"--out {out}: only .bvh or .glb or .gltf or .vrma can be written" in printed
    assert not out.exists()


def test_without_an_action_the_locomotion_is_written(bank: Bank, tmp_path: Path) -> None:
    run("splice", bank.path, "--locomotion", "walk", "--out", tmp_path / "walk.bvh")
    written = joint_positions(read_clip(tmp_path / "walk.bvh").clip)
    np.testing.assert_allclose(written, joint_positions(bank.motion("walk")), atol=1e-5)


def test_the_suffix_may_be_in_capital_letters(bank: Bank, tmp_path: Path) -> None:
    run("splice", bank.path, "--locomotion", "walk", "--action", "wave", "--out", tmp_path / "OUT.BVH")
    assert (tmp_path / "OUT.BVH").exists()


def test_errors_are_one_paragraph(
    bank: Bank, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def printed(*arguments: object) -> str:
        return failure(monkeypatch, capsys, *arguments)

    splice = ["splice", bank.path, "--action", "wave", "--out", tmp_path / "out.bvh", "--locomotion"]
    assert "Did you mean 'walk'" in printed(*splice, "wlak")
    assert "folder not found" in printed("inspect", tmp_path / "absent")
    assert "file or folder not found" in printed("precompute", tmp_path / "absent.bvh", "--out", tmp_path / "bank")
    unnamed = tmp_path / "unnamed.bvh"
    unnamed.write_bytes(dump_bvh(bank.motion("walk")).replace(b"LeftUpLeg", b"Alpha"))
    assert '[roles]\nleft_hip = ""' in printed("render", unnamed, "--out", tmp_path / "x.png")
    assert "absent.bvh" in printed("render", tmp_path / "absent.bvh", "--out", tmp_path / "x.png")
    assert "x.txt: only .png or .gif can be written" in printed(
        "render", bank.path.parents[0] / "x.bvh", "--out", tmp_path / "x.txt"
    )
    assert "exact splice chooses its own start" in printed(*splice, "walk", "--method", "exact", "--start", 1)
    assert "Choose --posture relative, absolute, off" in printed(
        *splice, "walk", "--method", "exact", "--posture", "running"
    )
    assert not (tmp_path / "out.bvh").exists()


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """A bank with two short locomotions, of which `stroll` loops and `step` does not."""
    walk, folder = CLIPS["walk"], tmp_path_factory.mktemp("short")
    clips = {"walk": walk, "stroll": walk.frames(0, 130), "step": walk.frames(0, 40), "carry": CLIPS["carry_box"]}
    clips |= {"run": CLIPS["run"], "lunge": CLIPS["run"].frames(0, 50)}
    settings = '[carry]\nkind = "action"\n[lunge]\nkind = "action"\n'
    return built(written(folder, clips, settings), folder / "bank")


def test_a_locomotion_that_cuts_the_action_short_is_reported_with_what_shows_more_of_it(
    short: Bank, tmp_path: Path
) -> None:
    splice = ["splice", short.path, "--action", "carry", "--out", tmp_path / "x.bvh", "--locomotion"]
    sentence = (
        r"'carry' is cut after \d\.\d\d of 4\.00 s, where 'stroll' ends; for all of it, repeat 'stroll': --seconds "
    )
    found = re.search(sentence + r"([\d.]+)\n", run(*splice, "stroll").output)
    assert found
    assert 3.0 < float(found[1]) < 4.5
    assert "choose a longer locomotion, or one that loops" in run(*splice, "step").output
    assert "is cut after" not in run(*splice, "walk").output


@pytest.mark.parametrize("method", ["splice", "naive", "none"])
def test_a_locomotion_repeats_for_as_many_seconds_as_asked(bank: Bank, tmp_path: Path, method: str) -> None:
    options = ["--locomotion", "run", "--action", "carry_box", "--posture", "absolute", "--method", method]
    for name, more in (("whole", []), ("long", ["--seconds", 7.5])):
        output = run("splice", bank.path, *options, *more, "--out", tmp_path / f"{name}.bvh").output
    assert "is cut after" not in output
    whole, long = (read_clip(tmp_path / f"{name}.bvh").clip for name in ("whole", "long"))
    assert (long.frame_count, whole.frame_count) == (451, 181)
    first = long.frames(0, 150)  # as the splice without an option
    np.testing.assert_allclose(first.rotations[:, 1:], whole.rotations[:150, 1:], atol=1e-3)
    speeds = np.linalg.norm(np.diff(joint_positions(long), axis=0), axis=2) * long.rate
    assert speeds.max() < 1.3 * speeds[:179].max()  # it repeats without a jump
    assert speeds[-60:, 0].min() > 1.0  # it still runs


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (["--seconds", "nan"], "cannot write nan seconds"),
        (["--seconds", "0"], "cannot write 0 seconds"),
        (["--seconds", "9", "--method", "exact"], "the exact splice is as long as its locomotion"),
    ],
)
def test_a_length_that_cannot_be_written_is_refused(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    bank: Bank,
    tmp_path: Path,
    options: list[str],
    problem: str,
) -> None:
    splice = ["splice", bank.path, "--locomotion", "walk", "--action", "wave", "--out", tmp_path / "x.bvh"]
    assert problem in failure(monkeypatch, capsys, *splice, *options)


def test_a_locomotion_that_cannot_loop_is_not_made_longer(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], short: Bank, tmp_path: Path
) -> None:
    splice = ["splice", short.path, "--locomotion", "step", "--action", "carry", "--out", tmp_path / "x.bvh"]
    assert "'step' cannot loop, so it lasts no longer than" in failure(monkeypatch, capsys, *splice, "--seconds", 3)


def test_a_gesture_that_is_not_marked_as_an_action_is_named_with_its_mend(tmp_path: Path) -> None:
    clips = {"walk": CLIPS["walk"], "hail": STANDING_CLIPS["hail"]}
    for name, settings in (("plain", ""), ("marked", '[hail]\nkind = "action"\n')):
        folder = tmp_path / name
        folder.mkdir()
        bank = written(folder, clips, settings) / "bank"
        built = run("precompute", folder, "--out", bank, "--baseline", "walk", "--jobs", 1).output
        splice = run(
            "splice", bank, "--locomotion", "walk", "--action", "hail", "--out", tmp_path / f"{name}.bvh"
        ).output
        for output in (built, splice):
            sentence = 'its legs hardly move. If it is an action, give it `kind = "action"` in clips.toml'
            assert (sentence in " ".join(output.split())) == (name == "plain")


def test_an_action_of_one_stride_that_does_not_fit_is_named_with_its_mend(short: Bank, tmp_path: Path) -> None:
    splice = ["splice", short.path, "--out", tmp_path / "x.bvh", "--locomotion"]
    sentence = "'lunge' takes one stride that does not fit 'walk': if it is a lunge or a step, not a gait, name an idle"
    assert sentence in run(*splice, "walk", "--action", "lunge").output
    assert "does not fit" not in run(*splice, "run", "--action", "lunge").output
    assert "does not fit" not in run(*splice, "run", "--action", "carry").output
