from __future__ import annotations

from pathlib import Path

import pytest

from bench.characters import worn_hands
from bench.characters.costs import played
from bench.findings import Findings
from bench.generated import Size, generate
from bench.speed.workload import Scene
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Poses, Requests
from motionsplice.runtime.stage import Stage


def test_what_is_timed_with_hands_has_them_and_the_other_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worn_hands, "COUNT", 5)
    evaluator = Evaluator(generate(tmp_path / "bank", Size(52, clips=2, seconds=3.0, hands=True)))
    stage, seen = Stage(evaluator), list[list[int]]()

    def evaluate(self: Evaluator, requests: Requests, *_: object) -> None:
        seen.append(requests.hands.tolist())

    def worn(self: Characters, out: Poses) -> None:
        seen.append(self.state[:, col.HANDS].astype(int).tolist())

    monkeypatch.setattr(Evaluator, "evaluate", evaluate)
    monkeypatch.setattr(Characters, "evaluate", worn)
    for hands in (False, True):
        worn_hands.asked(evaluator, Scene(), hands)(0)
    for names in ((), ("hands",), ("hands", "hands")):
        played(worn_hands.dressed(stage, names))(0)
    assert seen == [[number] * 5 for number in (0, 1, 0, 1, 2)]


def test_times_are_told_with_their_ratio() -> None:
    told = Findings("")
    worn_hands.compare(told, "work", lambda _: None, lambda _: sum(range(10_000)), rounds=5)
    assert [label for label, _, _ in told.rows] == [
        "work, without hands",
        "work, with hands",
        "work, with over without",
    ]
    assert float(told.rows[2][1]) > 2.0
