"""Actions captured standing, over HTTP: the list of clips, poses, and commands of characters."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from fastapi.testclient import TestClient

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.splice import Splice
from tests.service.answers.test_take import take
from tests.service.conftest import warm_client

WALK = {"do": "create", "locomotion": "walk"}


@pytest.fixture(scope="module")
def standing_client(standing_bank: Bank) -> Iterator[TestClient]:
    with warm_client(standing_bank) as client:
        yield client


def test_the_list_of_clips_says_which_stand_and_what_they_use(standing_client: TestClient) -> None:
    found = {clip["name"]: (clip["stands"], clip["uses"]) for clip in standing_client.get("/v1/clips").json()}
    assert found["hail"] == (True, ["right arm"])
    assert found["holding"] == (True, ["left arm", "right arm"])
    assert found["walk"] == found["idle"] == (False, [])
    assert standing_client.get("/v1/clips/hail").json()["uses"] == ["right arm"]


def test_a_pose_is_the_evaluators(standing_client: TestClient, standing_bank: Bank) -> None:
    answer = standing_client.get("/v1/pose", params={"locomotion": "run", "action": "jab", "time": 1.9}).json()
    expected = Evaluator(standing_bank).pose(Splice("run", "jab"), 1.9)
    np.testing.assert_allclose(answer["rotations"], expected.rotations[0], atol=1e-6)


@pytest.mark.parametrize(("keys", "own"), [({}, True), ({"own_clock": True}, True), ({"own_clock": False}, False)])
def test_a_take_plays_it_at_its_own_speed_unless_told_otherwise(
    standing_client: TestClient, keys: dict[str, bool], own: bool
) -> None:
    found = take(standing_client, 120, {**WALK, "locomotion": "run"}, {"do": "act", "action": "hail", **keys})
    speeds = np.diff(found["action_times"]) * 60.0
    assert (np.abs(speeds - 1.0).max() < 1e-3) == own


def test_a_take_is_the_splice_of_the_evaluator(standing_client: TestClient, standing_bank: Bank) -> None:
    found = take(standing_client, 200, WALK, {"do": "act", "action": "jab", "blend": 0})
    expected = Evaluator(standing_bank).sequence(Splice("walk", "jab"), np.arange(200) / 60.0)
    np.testing.assert_allclose(found["rotations"][:, 1:], expected.rotations[:, 1:], atol=1e-5)
