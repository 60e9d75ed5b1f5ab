"""What `precompute` and `inspect` print."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench.retarget.kinds import KINDS
from bench.retarget.rigs import on_rig
from motionsplice.cli import app
from motionsplice.commands.bank_report import print_grouped
from motionsplice.motion import quaternion
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.runtime.bank import Bank

WALK = make("walk", seconds=3.0)


def printed(*arguments: object, status: int = 0) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == status, result.output
    return result.output


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    for name, kind in (("a", "Mixamo"), ("b", "CMU"), ("c", "CMU")):
        (tmp_path / f"{name}.bvh").write_bytes(dump_bvh(on_rig(WALK, KINDS[kind])))
    return tmp_path


def test_precompute_counts_retargeted_clips_and_inspect_says_why(clips: Path) -> None:
    build = ["precompute", clips, "--out", clips / "bank", "--baseline", "a", "--jobs", 1]
    output = printed(*build)
    assert "2 of 3 clips were retargeted to the skeleton of 'a'; choose another with --skeleton" in output
    assert "assumed unit" not in output
    output = printed("inspect", clips / "bank")
    assert re.search(r"^b, c: retargeted by roles: the rigs have different topologies", output, re.MULTILINE)
    assert "assumed unit m" in output
    output = printed(*build[:3], clips / "bank2", "--skeleton", clips / "bank")
    assert f"retargeted to the skeleton of {clips / 'bank'}\n" in output


def test_clips_that_fail_alike_are_listed_once(clips: Path) -> None:
    output = printed("precompute", clips, "--out", clips / "bank", "--baseline", "a", "--no-retarget", status=1)
    assert output.count("Allow retargeting") == 1
    assert f"b, c failed: {clips / 'b.bvh'} and 1 more file: the rigs have different topologies" in output


def test_a_roles_file_that_does_not_fit_all_clips_leads_to_clips_toml(clips: Path) -> None:
    (clips / "odd.toml").write_text('[roles]\nhead = "mixamorig:Head"\n')
    build = ["precompute", clips, "--out", clips / "bank", "--baseline", "a", "--roles", clips / "odd.toml"]
    output = printed(*build, status=1)
    assert "unknown joint 'mixamorig:Head' for role head" in output
    assert "For a few, set `roles` in clips.toml" in output
    (clips / "clips.toml").write_text('[a]\nroles = "odd.toml"\n')
    printed(*build[:-2])


def test_a_bank_without_actions_has_no_columns_for_them(clips: Path, bank: Bank) -> None:
    printed("precompute", clips, "--out", clips / "bank", "--jobs", 1)
    for folder, expected in ((clips / "bank", False), (bank.path, True)):
        output = printed("inspect", folder)
        assert ("neutral" in output, "shoulders" in output) == (expected, expected)


def test_names_are_cut_short(capsys: pytest.CaptureFixture[str]) -> None:
    moves = [f"moves:{number}" for number in range(3)]
    walks = [f"walk{number}" for number in range(8)]
    for named, text in (
        (moves, "moves:*"),
        (moves[:2], "moves:0, moves:1"),
        (["walk1", *moves], "walk1, moves:*"),
        (["one:run"], "one:run"),
        (walks, "walk0, walk1, walk2, walk3, walk4, walk5 and 2 more"),
    ):
        print_grouped("dim", [(name, "a [note]") for name in named], [*moves, *walks, "one:run"])
        assert capsys.readouterr().out == f"{text}: a [note]\n"


def test_standing_actions_have_their_stance_as_neutral_and_no_cycles(standing_bank: Bank) -> None:
    output = printed("inspect", standing_bank.path)
    (row,) = (line for line in output.splitlines() if "hail" in line and "│" in line)
    cells = [cell.strip() for cell in row.split("│")[1:-1]]
    assert cells[:7] == ["hail", "itself", "5.00", "60", "", "", ""]
    assert "hail: stands, so it plays at its own speed; it uses right arm" in output


@pytest.mark.parametrize("posture", ["relative", "absolute"])
def test_a_standing_action_is_spliced_by_every_method(standing_bank: Bank, tmp_path: Path, posture: str) -> None:
    splices = {}
    for method in ("splice", "exact"):
        names = ("--locomotion", "walk", "--action", "bow", "--method", method, "--posture", posture)
        printed("splice", standing_bank.path, *names, "--out", tmp_path / f"{method}.bvh")
        splices[method] = read_clip(tmp_path / f"{method}.bvh").clip
    frames = min(clip.frame_count for clip in splices.values())
    one, other = (clip.rotations[:frames] for clip in splices.values())
    assert (quaternion.angle(one, other).max() < 1e-3) == (posture == "relative")
