from __future__ import annotations

from pathlib import Path

import pytest

from bench.characters import worn_hands
from bench.characters.costs import compare, frame_work
from bench.findings import Findings
from bench.generated import Size, generate
from bench.speed.workload import Scene
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Poses, Requests
from motionsplice.runtime.stage import Stage


def test_only_work_timed_with_hands_has_hands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worn_hands, "COUNT", 5)
    evaluator = Evaluator(generate(tmp_path / "bank", Size(52, clips=2, seconds=3.0, hands=True)))
    stage, hands_evaluated = Stage(evaluator), list[list[int]]()

    def evaluate(self: Evaluator, requests: Requests, *_: object) -> None:
        hands_evaluated.append(requests.hands.tolist())

    def evaluate_characters(self: Characters, out: Poses) -> None:
        hands_evaluated.append(self.state[:, col.HANDS].astype(int).tolist())

    monkeypatch.setattr(Evaluator, "evaluate", evaluate)
    monkeypatch.setattr(Characters, "evaluate", evaluate_characters)
    for hands in (False, True):
        worn_hands.splice_work(evaluator, Scene(), hands)(0)
    for names in ((), ("hands",), ("hands", "hands")):
        frame_work(worn_hands.with_hands(stage, names))(0)
    assert hands_evaluated == [[number] * 5 for number in (0, 1, 0, 1, 2)]


def test_times_are_listed_with_their_ratio() -> None:
    findings = Findings("")
    compare(findings, "work", {"less": lambda _: None, "more": lambda _: sum(range(10_000))}, rounds=5)
    assert [label for label, _, _ in findings.rows] == [
        "work, less",
        "work, more",
        "work, more / less",
    ]
    assert float(findings.rows[2][1]) > 2.0
