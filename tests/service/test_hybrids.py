"""Actions that stand and walk by turns, over HTTP: the list of clips, poses, takes and their events."""

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
def talk_client(talk_bank: Bank) -> Iterator[TestClient]:
    with warm_client(talk_bank) as client:
        yield client


def test_the_list_of_clips_names_the_stretches(talk_client: TestClient) -> None:
    found = {clip["name"]: clip["stretches"] for clip in talk_client.get("/v1/clips").json()}
    assert found["talk"] == ["talk~1", "talk~2", "talk~3"]
    assert found["talk~2"] == found["walk"] == []


@pytest.mark.parametrize("time", [2.0, 4.3, 6.0, 8.2, 11.0])
def test_a_pose_is_the_evaluators(talk_client: TestClient, talk_bank: Bank, time: float) -> None:
    answer = talk_client.get("/v1/pose", params={"locomotion": "walk", "action": "talk", "time": time}).json()
    expected = Evaluator(talk_bank).pose(Splice("walk", "talk"), time)
    np.testing.assert_allclose(answer["rotations"], expected.rotations[0], atol=1e-6)


def test_a_take_tells_the_time_of_the_whole_action_and_names_it(talk_client: TestClient, talk_bank: Bank) -> None:
    found = take(talk_client, 840, WALK, {"do": "act", "action": "talk", "loop": False})
    times = np.asarray(found["action_times"])
    stands = (times > talk_bank.begin_of("talk~2") + 0.1) & (times < talk_bank.begin_of("talk~3") - 0.1)
    np.testing.assert_allclose(np.diff(times[stands]), 1.0 / 60.0, atol=1e-4)
    ended = [one for one in found["events"] if one["event"].startswith("action")]
    assert [(one["event"], one["action"]) for one in ended] == [("action_ended", "talk")]
