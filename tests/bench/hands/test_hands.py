from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.findings import Findings
from bench.hands.accuracy import constrained, errors
from bench.hands.sequences import Sequence, captured, sequence
from bench.hands.warping import from_trunk, warped
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.gestures import sample_gestures
from motionsplice.motion.quaternion import about, rotate
from motionsplice.precompute.hands.points import HandMotion


@pytest.fixture(scope="module")
def drawn() -> list[Sequence]:
    return [sequence(seed) for seed in (1, 2, 3)]


def values(findings: Findings) -> dict[str, float]:
    return {label: float(value) for label, value, _ in findings.rows}


def test_sequences_have_the_papers_sizes(drawn: list[Sequence]) -> None:
    for one in drawn:
        assert 280 <= len(one.truth) <= 571
        assert [len(hand.points) for hand in one.body] == [len(one.truth)] * 2
        assert one.truth[-1] == pytest.approx(len(one.hands[0].points) - 1)
        assert 0.2 < one.moving.mean() < 1.0
    repeated = sequence(1)
    assert np.array_equal(repeated.body[0].points, drawn[0].body[0].points)


def test_both_passes_find_the_truth_and_positions_do_not(drawn: list[Sequence]) -> None:
    found = values(errors("three", drawn))
    assert found["both passes, median"] <= 1.0
    assert found["both passes, 95th percentile"] < found["first pass, 95th percentile"]
    assert found["mean of both passes / mean of positions"] < 0.5
    assert found["mean of both passes / mean of derivatives"] < 1.0


def test_plain_time_warping_of_a_motion_with_itself_is_the_identity(drawn: list[Sequence]) -> None:
    one = drawn[0]
    same = one._replace(hands=one.body)
    np.testing.assert_array_equal(warped(same, from_trunk), np.arange(len(one.truth)))


def test_points_relative_to_the_trunk_do_not_depend_on_its_heading(drawn: list[Sequence]) -> None:
    hand = drawn[0].body[0]
    assert hand.trunk is not None
    turned = HandMotion(rotate(about([0.0, 1.0, 0.0], 2.0), hand.points), hand.trunk + 2.0)
    np.testing.assert_allclose(from_trunk(turned), from_trunk(hand), atol=1e-9)


def test_pairs_are_hit_and_help_where_gestures_are_ambiguous() -> None:
    found = values(constrained(3))
    assert found["largest distance from a pair beyond its tolerance"] <= 0.0
    assert found["with three pairs, median over sequences"] < found["without pairs, median over sequences"]


def test_captured_arms_are_aligned_with_their_copy(tmp_path: Path) -> None:
    (tmp_path / "directions.bvh").write_bytes(dump_bvh(sample_gestures()["directions"]))
    (one,) = captured(tmp_path)
    assert 0.2 < one.moving.mean() <= 1.0
    assert 0 <= one.truth[-1] - (len(one.hands[0].points) - 1) < 1.0
    for mine, other in zip(one.body, one.hands, strict=True):
        ranges = [float(np.ptp(hand.points[:, 3], axis=0).max()) for hand in (mine, other)]
        assert 0.15 < ranges[1] / ranges[0] < 1.1
    found = values(errors("one", [one]))
    assert found["both passes, median"] <= 1.0
    assert found["both passes, median"] < found["positions, median"]
