"""The characters of a connection, without a socket."""

from __future__ import annotations

import numpy as np
import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.service.characters import scene
from motionsplice.service.characters.commands import checked, parse
from motionsplice.service.characters.scene import Scene
from motionsplice.service.serving import Edition


@pytest.fixture(scope="module")
def edition(bank: Bank) -> Edition:
    return Edition.warm(bank)


def playing(edition: Edition) -> Scene:
    found = Scene(edition, 60.0, 100)
    for command in checked(parse('[{"do": "create", "id": [5, 6], "locomotion": "walk"},'
                                 '{"do": "act", "id": 6, "action": "wave"}]')):  # fmt: skip
        found.do(command)
    return found


def test_a_few_frames_are_left_out_as_if_they_had_been_evaluated(edition: Edition) -> None:
    evaluated, late = playing(edition), playing(edition)
    for _ in range(50):
        evaluated.pass_frame()
    late.leave_out(50)
    assert late.characters.state.tobytes() == evaluated.characters.state.tobytes()


def test_many_frames_are_left_out_in_long_steps(edition: Edition, monkeypatch: pytest.MonkeyPatch) -> None:
    evaluated, late = playing(edition), playing(edition)
    for _ in range(50):
        evaluated.pass_frame()
    monkeypatch.setattr(scene, "FEW", 99)
    monkeypatch.setattr(Scene, "pass_frame", None)
    late.leave_out(50)
    places = [col.PLACE, col.PLACE + 2, col.FIRST_LOCOMOTION + col.PHASE]
    np.testing.assert_allclose(late.characters.state[:, places], evaluated.characters.state[:, places], atol=0.02)
