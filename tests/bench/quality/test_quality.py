"""Tests of the quality report, and of its targets on the built-in motions."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from bench.quality import __main__ as quality
from bench.quality import pair_list
from bench.quality.claims import CLAIMS, Performance
from bench.quality.dissection import Dissection
from bench.quality.document import document
from bench.quality.judge import claim_values, judge
from bench.quality.pair_list import (
    EXAMPLES,
    Pair,
    grid_pairs,
    has_built_in_clips,
    pairs_of_bank,
    read_pairs,
    truth_of,
)
from bench.quality.report import Cell, by_part, means_table, pair_table
from bench.quality.scores import ClipScore, Form, MethodScore, PairScore, score_clip, score_pair, splice_pair
from bench.quality.targets import BUILT_IN, REAL, targets
from motionsplice.motion import quaternion
from motionsplice.motion.errors import SettingsError, UnknownClipError
from motionsplice.motion.procedural.library import ACTIONS, LOCOMOTIONS
from motionsplice.motion.samples import write_sample_clips
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.service.report import QualityReport

FORMS = (Form("naive"), Form("exact"), Form("splice"))


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Bank:
    """The bank of all built-in motions, on an automatic baseline."""
    folder = tmp_path_factory.mktemp("samples")
    write_sample_clips(folder / "clips")
    build_bank([folder / "clips"], folder / "bank")
    return Bank.open(folder / "bank")


@pytest.fixture(scope="module")
def grid(samples: Bank) -> list[PairScore]:
    """Every built-in action on every built-in locomotion, scored."""
    evaluator = Evaluator(samples)
    return [judge(evaluator, pair, FORMS).score for pair in grid_pairs()]


def test_splices_of_built_in_motion_meet_every_target(samples: Bank, grid: list[PairScore]) -> None:
    found = targets(grid, [score_clip(samples, clip.name) for clip in samples.clips], BUILT_IN)
    assert len(found) == 8
    assert not [target for target in found if not target.met]


def test_no_splice_beats_the_oracle_and_alignments_never_go_back(grid: list[PairScore]) -> None:
    assert len(grid) == len(LOCOMOTIONS) * len(ACTIONS)
    for pair in grid:
        naive, exact, splice = pair.methods
        assert naive.ratio == pytest.approx(1.0)
        assert pair.oracle is not None
        assert splice.error is not None
        assert pair.oracle < splice.error
        assert exact.monotone
        assert splice.monotone
        assert exact.change is not None
        assert exact.change < 1e-6


def test_on_a_walk_each_posture_form_keeps_its_promise_and_relative_is_closest(samples: Bank) -> None:
    evaluator, pair = Evaluator(samples), Pair("walk", "punch", "walk+punch")
    forms = [Form("naive"), *(Form("splice", form) for form in ("relative", "absolute", "off"))]
    splices = [splice_pair(evaluator, pair.locomotion, pair.action, form) for form in forms]
    score = score_pair(evaluator, "walk", "punch", truth_of(pair, samples), splices)
    ratios = {one.method: one.ratio or 0.0 for one in score.methods}
    assert min(ratios, key=lambda name: ratios[name]) == "splice"
    assert max(one.posture or 0.0 for one in score.methods) < 1.0


def test_the_thesis_examples_match_their_truth(samples: Bank) -> None:
    evaluator, pairs = Evaluator(samples), read_pairs(EXAMPLES)
    assert len(pairs) == 9
    assert {pair.claim for pair in pairs} <= CLAIMS.keys()
    for pair in pairs:
        if CLAIMS[pair.claim].unit != "°":
            continue
        values = claim_values(samples, judge(evaluator, pair, FORMS))
        assert values["splice"] == pytest.approx(values["truth"], abs=4.0), pair.example


def test_claims_have_known_answers(samples: Bank) -> None:
    walk, roles = samples.motion("walk"), samples.roles
    walking = Performance(walk, samples.phase("walk"), roles)
    leaning = walk.rotations.copy()
    turn = quaternion.about([1.0, 0.0, 0.0], np.radians(10.0))
    root = quaternion.conjugate(leaning[:, 0])
    local = quaternion.multiply(quaternion.multiply(root, turn), leaning[:, 0])
    leaning[:, roles.pelvis] = quaternion.multiply(local, leaning[:, roles.pelvis])
    bent = Performance(replace(walk, rotations=leaning), walking.phase, roles)
    lean, tilt = CLAIMS["lean"].measure, CLAIMS["tilt"].measure
    assert lean(bent, bent) - lean(walking, walking) == pytest.approx(10.0, abs=0.5)
    assert tilt(bent, walking) > tilt(walking, walking) + 4.0
    assert CLAIMS["growth"].measure(walking, walking) == pytest.approx(1.0, abs=0.1)
    assert CLAIMS["timing"].measure(walking, walking) == 0.0
    assert CLAIMS["steadiness"].measure(walking, walking) > 0.95


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("locomotion,action,truht\nwalk,wave,walk\n", "line 2: unknown column 'truht'"),
        ("locomotion,action\nwalk,\n", "line 2: locomotion or action is missing"),
        ("locomotion,action,truth,aligned\nwalk,wave,run,no\n", "line 2: aligned is 'no', expected yes or nothing"),
        ("locomotion,action,claim\nwalk,wave,leen\n", "unknown claim 'leen'. Did you mean 'lean'"),
    ],
)
def test_an_invalid_pair_file_is_refused_with_its_line(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "pairs.csv"
    file.write_text(text)
    with pytest.raises(SettingsError) as raised:
        read_pairs(file)
    assert words in str(raised.value)
    assert str(file) in str(raised.value)
    with pytest.raises(SettingsError, match="cannot be read"):
        read_pairs(tmp_path / "absent.csv")


def test_a_truth_is_a_clip_or_a_built_in_motion_or_unknown(samples: Bank) -> None:
    assert truth_of(Pair("walk", "wave"), samples) is None
    assert truth_of(Pair("walk", "wave", "run"), samples).name == "run"  # type: ignore[union-attr]
    assert truth_of(Pair("walk", "wave", "run+wave"), samples).name == "run+wave"  # type: ignore[union-attr]
    aligned = truth_of(Pair("walk", "wave", "slow_walk", aligned="yes"), samples)
    assert aligned is not None
    assert (aligned.name, aligned.rate) == ("slow_walk, aligned", samples.clip("walk").rate)
    with pytest.raises(UnknownClipError, match="Did you mean 'walk'"):
        truth_of(Pair("walk", "wave", "wlak"), samples)


def method(name: str, ratio: float, jitter: float = 1.0) -> MethodScore:
    return MethodScore(name, 1.0, 2.0 * ratio, 5.0, ratio, 0.5, 3.0, jitter, 1.0, True, (0.5, 2.0), 1.1, 1.0, 1e-5)


def pair(action: str, ratio: float) -> PairScore:
    methods = method("naive", 1.0), method("exact", 0.4), method("splice", ratio)
    lacks = Dissection(lag=0.9, lag_seconds=0.1, time=0.7, torso=0.8, oracle=0.5)
    return PairScore("walk", action, "t", 1.0, 0.5, lacks, methods)


def test_targets_name_the_worst_pair_and_whether_they_are_met() -> None:
    clip = ClipScore("walk", "locomotion", 5.0, 5, 4.0, 0.9, None)
    found = {one.what: one for one in targets([pair("a", 0.2), pair("b", 0.8)], [clip], REAL)}
    worst = found["error / naive splice, worst pair"]
    assert (worst.found, worst.wanted, worst.met) == ("0.8 (walk <- b)", "<= 0.7", False)
    assert found["error / naive splice, mean of all pairs"].found == "0.50"
    assert found["error / oracle that knows the truth"].found == "2.00"
    assert found["phase concentration, lowest locomotion"].found == "0.900 (walk)"
    assert not found["phase concentration, lowest locomotion"].met
    assert found["jitter of the neck / larger source, worst pair"].met


def test_tables_have_a_row_per_pair_with_graded_cells() -> None:
    columns, rows = pair_table([pair("a", 0.2), pair("b", 0.8)])
    assert all(len(row) == len(columns) for row in rows)
    ratio = columns.index("splice\nratio")
    assert [row[ratio] for row in rows] == [Cell("0.20", "good"), Cell("0.80", "bad")]
    assert rows[0][columns.index("best time\nratio")] == Cell("0.35")
    groups, means = means_table(by_part([pair("a", 0.2), pair("b", 0.8)], "locomotion"))
    assert groups == ["mean / worst", "walk (2)", "all (2)"]
    assert [cell.text for cell in means[1]] == ["splice", "0.50 / 0.80", "0.50 / 0.80"]
    assert [cell.text for cell in means[-1]] == ["oracle", "0.25 / 0.25", "0.25 / 0.25"]


def test_the_command_writes_numbers_and_a_page_with_pictures(tmp_path: Path) -> None:
    clips, pairs = tmp_path / "clips", tmp_path / "pairs.csv"
    write_sample_clips(clips)
    for file in clips.glob("*.bvh"):
        if file.stem not in ("walk", "curve", "wave"):
            file.unlink()
    settings = (clips / "clips.toml").read_text()
    (clips / "clips.toml").write_text(settings[settings.index("[wave]") :])
    pairs.write_text("locomotion,action,truth,example,claim\ncurve,wave,curve+wave,Waving,twist\nwalk,wave,,,\n")
    app = typer.Typer()
    app.command()(quality.main)
    result = CliRunner().invoke(app, [str(clips), "--pairs", str(pairs), "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert "curve <- wave" in result.output
    scores = json.loads((tmp_path / "out" / "scores.json").read_text())
    assert [one["truth"] for one in scores["pairs"]] == ["curve+wave", ""]
    assert [one["method"] for one in scores["pairs"][0]["methods"]] == ["naive", "additive", "exact", "splice"]
    assert scores["pairs"][0]["lacking"].keys() == {"lag", "lag_seconds", "time", "torso", "oracle"}
    page = (tmp_path / "out" / "index.html").read_text()
    assert page.count("data:image/png;base64,") == 1 + 2 * 2
    assert "Waving: curve &lt;- wave" in page


def test_numbers_name_their_bank_and_the_worst_moment_of_each_pair(samples: Bank) -> None:
    evaluator = Evaluator(samples)
    pairs = [Pair("curve", "wave", "curve+wave"), Pair("walk", "wave"), Pair("curve", "wave", "curve+wave", "Waving")]
    judged = [judge(evaluator, pair, FORMS) for pair in pairs]
    numbers = json.loads(json.dumps(document(samples, judged, [], [])))
    report = QualityReport.model_validate(numbers)
    assert report.bank == samples.digest
    assert [(one.locomotion, one.truth, one.example, one.measure) for one in report.pairs] == [
        ("curve", "curve+wave", "Waving", "error"),
        ("walk", "", "", "legs"),
    ]
    for pair, one in zip(report.pairs, judged, strict=False):
        values = pair.over_time["splice"]
        assert len(values) == int(one.splices[-1].clip.duration * report.rate + 1e-6) + 1
        assert pair.worst.value == max(values)
        assert values[round(pair.worst.time * report.rate)] == pair.worst.value
    assert np.mean(report.pairs[0].over_time["splice"]) == pytest.approx(report.pairs[0].methods[-1].error, rel=0.02)
    assert set(report.pairs[1].over_time) == {"exact", "splice"}


def test_a_bank_is_judged_as_it_is(bank: Bank, tmp_path: Path) -> None:
    app, pairs = typer.Typer(), tmp_path / "pairs.csv"
    app.command()(quality.main)
    pairs.write_text("locomotion,action,truth\nrun,wave,run\n")
    command = ["--bank", str(bank.path), "--pairs", str(pairs), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    assert f"motionsplice serve {bank.path} --report {tmp_path / 'out' / 'scores.json'}" in result.output
    assert json.loads((tmp_path / "out" / "scores.json").read_text())["bank"] == bank.digest
    refused = CliRunner().invoke(app, [*command, "--baseline", "run"])
    assert isinstance(refused.exception, SettingsError)


def test_without_a_list_all_actions_of_a_bank_are_judged_on_all_locomotions(
    bank: Bank, samples: Bank, monkeypatch: pytest.MonkeyPatch
) -> None:
    pairs = pairs_of_bank(bank)
    assert len(pairs) == 5 * 2
    assert Pair("run", "wave") in pairs
    assert (has_built_in_clips(samples), has_built_in_clips(bank)) == (True, False)
    monkeypatch.setattr(pair_list, "MOST_PAIRS", 9)
    with pytest.raises(SettingsError, match=r"the bank has 10 pairs .* --pairs"):
        pairs_of_bank(bank)
