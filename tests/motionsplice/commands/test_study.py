from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rich.console import Console
from typer.testing import CliRunner

from motionsplice.cli import app, main
from motionsplice.commands import study as command_study
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.motion.roles import find_roles
from motionsplice.pictures.correlation_charts import draw_chart
from motionsplice.pictures.stick_figure import LEFT
from motionsplice.precompute.study.body_angles import View
from motionsplice.precompute.study.correlation import Survival, study, survival
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Method
from motionsplice.runtime.splice import Splice
from tests.conftest import CLIPS

ROLES = find_roles(CLIPS["walk"].skeleton)
WALK = study(CLIPS["walk"], ROLES)


@pytest.fixture(autouse=True)
def _wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_study, "console", Console(width=200))


def output_of(*arguments: object) -> str:
    result = CliRunner().invoke(app, ["study", *(str(argument) for argument in arguments)])
    assert result.exit_code == 0, result.output
    return result.output


def written(folder: Path, **clips: Clip) -> list[Path]:
    files = [folder / f"{name}.bvh" for name in clips]
    for file, clip in zip(files, clips.values(), strict=True):
        file.write_bytes(dump_bvh(clip))
    return files


def test_the_table_has_a_row_for_every_correlation(tmp_path: Path) -> None:
    output = output_of(*written(tmp_path, walk=CLIPS["walk"]), "--unit", "m")
    rows = [line for line in output.splitlines() if any(word in line for word in ("in phase", "opposite", "at a lag"))]
    assert len(rows) == pytest.approx(len(WALK.found), abs=2)  # BVH rounds
    assert f"walk: {len(rows)} correlations" in output
    assert not list(tmp_path.glob("*.json"))


def test_what_survives_is_marked_and_counted(tmp_path: Path) -> None:
    walk = CLIPS["walk"]
    rotations = walk.rotations.copy()
    upper = walk.skeleton.subtree(ROLES.pelvis)
    rotations[:, upper] = walk.sampled(0.72 * np.arange(walk.frame_count))[1][:, upper]
    slow = Clip("slow", walk.skeleton, walk.rate, walk.root_positions, rotations)
    files = written(tmp_path, walk=walk, same=walk, slow=slow)
    output = output_of(*files, "--unit", "m", "--out", tmp_path / "out")
    first, same, other = json.loads((tmp_path / "out" / "study.json").read_text())
    found = [one for one in first["correlations"] if one["verdict"] not in ("none", "still")]
    assert f"same: {len(found)} of {len(found)} correlations kept, 0 changed, 0 lost" in output
    lost = [one for one in other["correlations"] if one["lag_from_first_degrees"] is not None]
    missing = sum(one["verdict"] in ("none", "still") for one in lost)
    assert f"changed, {missing} lost" in output
    assert missing > 0.7 * len(found)
    assert same["correlations"] == first["correlations"]


def test_out_holds_two_plots_of_each_motion_and_the_numbers(tmp_path: Path) -> None:
    output_of(*written(tmp_path, walk=CLIPS["walk"], wave=CLIPS["wave"]), "--unit", "m", "--out", tmp_path / "a" / "b")
    plots = {f"{name}-{view}.png" for name in ("walk", "wave") for view in View}
    assert {file.name for file in (tmp_path / "a" / "b").iterdir()} == {*plots, "study.json"}
    walk, _ = json.loads((tmp_path / "a" / "b" / "study.json").read_text())
    assert walk["strides"] == pytest.approx(float(WALK.phase[-1] - WALK.phase[0]), abs=0.05)
    twist = next(one for one in walk["correlations"] if (one["joint"], one["axis"]) == ("shoulders over hips", "twist"))
    assert twist["verdict"] == "in phase"
    assert twist["p"] < 0.01
    assert 5.0 < twist["amplitude_degrees"] < 20.0


def test_a_chart_draws_correlations_and_the_swing(tmp_path: Path) -> None:
    inks = []
    for name in ("walk", "carry_box"):
        draw_chart(study(CLIPS[name], ROLES), View.LOCAL, tmp_path / f"{name}.png")
        with Image.open(tmp_path / f"{name}.png") as chart:
            pixels = np.asarray(chart.convert("RGB"))
        assert pixels.shape[1] >= 1000
        inks.append(np.count_nonzero((pixels == LEFT).all(axis=-1)))
    assert inks[0] > 1.2 * inks[1] > 1000  # a box keeps the arms still


@pytest.mark.parametrize(("method", "least", "most"), [("splice", 0.85, 1.0), ("naive", 0.0, 0.3)])
def test_a_splice_keeps_what_a_naive_one_loses(bank: Bank, method: Method, least: float, most: float) -> None:
    first = study(make("walk", "wave", seed=1, seconds=5.0), ROLES)  # how the walk's own actor waves
    other = study(Evaluator(bank).clip(Splice("walk", "wave", method=method)), bank.roles)
    fates = [survival(one, other) for one in first.found.values()]
    assert least <= fates.count(Survival.KEPT) / len(fates) <= most


def test_an_error_is_one_paragraph(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (short,) = written(tmp_path, short=CLIPS["walk"].frames(0, 30))
    (long,) = written(tmp_path, walk=CLIPS["walk"])
    twin = tmp_path / "twin" / "walk.bvh"
    twin.parent.mkdir()
    twin.write_bytes(long.read_bytes())
    for files, words in (((short,), "'short' has no stride"), ((long, twin), "two motions are named 'walk'")):
        monkeypatch.setattr(sys, "argv", ["motionsplice", "study", *map(str, files), "--unit", "m"])
        with pytest.raises(SystemExit) as end:
            main()
        assert end.value.code == 1
        printed = capsys.readouterr().err
        assert printed.startswith("error: ")
        assert words in printed.replace("\n", " ")
