"""Layers over locomotion and action: feet are locked, head, chest and arms turn to a point that is dragged."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.characters.action import Action
from motionsplice.runtime.characters.aim import Aim, Look
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.stage import Stage
from tests.viewer.conftest import View
from tests.viewer.test_playing import chosen, distances, joints

TIME, POINT = 1.5, (1.5, 1.2, 4.0)
SHOWN: dict[str, Any] = {"locomotion": "run", "action": "carry_box", "time": TIME, "layout": "over"}
GIZMO = """const { camera, canvas } = viewer.stage, box = canvas.getBoundingClientRect();
    const seen = viewer.target.place.clone().project(camera);
    return [box.x + (seen.x + 1) / 2 * box.width, box.y + (1 - seen.y) / 2 * box.height]"""


def expected(bank: Bank, tell: Callable[[Characters], None], method: Any = "splice") -> Floats:
    """Returns how far joints are apart in the pose of a character that is told to look, aim or lock its feet."""
    characters = Characters(Stage(Evaluator(bank)), 60.0)
    characters.add(1, "run", loop=False)
    characters.act([0], Action("carry_box", blend=0.0, method=method))
    tell(characters)
    evaluator, poses = characters.stage.evaluator, characters.stage.evaluator.poses(1)
    for _ in range(round(TIME * 60)):
        characters.advance()
        characters.evaluate(poses)
    places = np.empty((1, bank.skeleton.joint_count, 3), np.float32)
    evaluator.world_positions(poses, places)
    return distances(places[0].astype(np.float64))


def aim_all(characters: Characters) -> None:
    characters.look([0], Look(POINT, weight=0.8), blend=0.0)
    characters.aim([0], Aim(POINT, weight=0.8, steady=1.0), blend=0.0)
    characters.aim([0], Aim(POINT, part="left_arm", weight=0.8), blend=0.0)


def test_splice_and_naive_look_and_aim_and_the_others_do_not(view: View, bank: Bank) -> None:
    view.show(**SHOWN, show="splice,naive,locomotion", point=" ".join(map(str, POINT)), turned=0.8, steady="true")
    *_, alone = joints(view)
    for key in "haq":
        view.page.keyboard.press(key)
    view.settle()
    splice, naive, locomotion = joints(view)
    assert np.abs(distances(splice) - expected(bank, aim_all)).max() < 1e-4
    assert np.abs(distances(naive) - expected(bank, aim_all, "naive")).max() < 1e-4
    np.testing.assert_array_equal(locomotion, alone)
    state = chosen(view)
    assert {state[key] for key in ("look", "chest", "left_arm")} == {"true"}
    assert "right_arm" not in state


def test_feet_are_locked(view: View, bank: Bank) -> None:
    view.show(**SHOWN)
    before = joints(view)
    view.page.get_by_role("checkbox", name="Lock feet").click()
    view.settle()
    for shown, method in zip(joints(view), ("splice", "naive"), strict=True):
        found = expected(bank, lambda characters: characters.lock_feet([0]), method)
        assert np.abs(distances(shown) - found).max() < 1e-4
    assert np.abs(joints(view) - before).max() > 0.002
    view.page.keyboard.press("g")
    view.settle()
    np.testing.assert_allclose(joints(view), before, atol=1e-6)


def test_the_point_is_put_ahead_and_dragged(view: View, bank: Bank) -> None:
    view.show(**SHOWN, show="splice")
    place = joints(view)[0, 0]
    view.page.get_by_role("checkbox", name="Head").click()
    view.settle()
    point = np.array(chosen(view)["point"].split(), float)
    assert 1.0 < np.linalg.norm(point - place) < 3.0
    x, y = gizmo(view)
    mouse = view.page.mouse
    mouse.move(x, y - 40)
    mouse.down()  # on the arrow that points up
    for step in range(1, 21):
        mouse.move(x + step, y - 40 - 2 * step)
    mouse.up()
    view.settle()
    up = np.array(chosen(view)["point"].split(), float)
    np.testing.assert_array_equal(up[[0, 2]], point[[0, 2]])
    assert up[1] > point[1] + 0.1
    found = expected(bank, lambda characters: characters.look([0], Look(up), blend=0.0))  # type: ignore[arg-type]
    assert np.abs(distances(joints(view)[0]) - found).max() < 1e-4
    assert "camera" not in chosen(view)  # the camera has stayed


@pytest.mark.parametrize("angle", ["free", "top"])
def test_its_middle_is_dragged_in_the_plane_of_the_picture(view: View, angle: str) -> None:
    view.show(**SHOWN, show="splice", look="true", view=angle)
    x, y = gizmo(view)
    mouse = view.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + 60, y - 30, steps=5)
    mouse.up()
    view.settle()
    np.testing.assert_allclose(gizmo(view), (x + 60, y - 30), atol=1.5)


def test_a_link_with_a_point_shows_the_same(view: View) -> None:
    view.open(**SHOWN, look="true", right_arm="true", lock_feet="true", point="0.5 1.1 3")
    expect(view.page.get_by_role("spinbutton", name="Point, Z")).to_have_value("3")
    found, address = joints(view), view.page.url
    view.page.get_by_role("spinbutton", name="Point, X").fill("-0.5")
    view.settle()
    assert chosen(view)["point"] == "-0.5 1.1 3"
    assert np.abs(joints(view) - found).max() > 0.05
    view.page.goto(address)
    view.settle()
    np.testing.assert_allclose(joints(view), found, atol=1e-5)


def gizmo(view: View) -> tuple[float, float]:
    """Returns where the point is seen, in pixels of the page."""
    found: Any = view.run(GIZMO)
    return found[0], found[1]
