"""What an animator does: choose clips, play, compare."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any
from urllib.parse import parse_qs, urlparse

import numpy as np
from playwright.sync_api import BrowserContext, expect

from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.expectation import expectation
from motionsplice.runtime.splice import Splice
from tests.service.running import Running
from tests.viewer.conftest import View, until

JOINTS = "return viewer.show.positions().map((one) => Array.from(one))"


def chosen(view: View) -> dict[str, str]:
    """Returns the state as the address holds it."""
    view.run("while (location.search !== `?${state.query}`) await new Promise(requestAnimationFrame)")
    return {key: values[0] for key, values in parse_qs(urlparse(view.page.url).query).items()}


def joints(view: View) -> Floats:
    """Returns the places [sides, J, 3] of the joints that are shown."""
    found: Any = view.run(JOINTS)
    return np.array(found).reshape(len(found), -1, 3)


def distances(positions: Floats) -> Floats:
    """Returns how far each joint is from each other, which does not depend on where the character stands."""
    return np.asarray(np.linalg.norm(positions[:, None] - positions[None], axis=-1))


def test_it_begins_with_the_baseline(view: View) -> None:
    view.open()
    expect(view.page.get_by_role("option", name="walk", exact=False).first).to_have_attribute("aria-selected", "true")
    assert chosen(view)["locomotion"] == "walk"


def test_a_click_plays_a_clip_soon(view: View) -> None:
    view.show()
    view.page.locator("#lists").get_by_role("option").filter(has_text="wave").click()
    view.settle()
    assert chosen(view)["action"] == "wave"
    assert view.run("return viewer.shown.map(({ name }) => name)") == ["splice", "naive"]


def test_the_joints_are_the_services(view: View, bank: Bank) -> None:
    view.show(locomotion="run", action="carry_box", time=1.0, layout="over")
    found, evaluator = joints(view), Evaluator(bank)
    for shown, method in zip(found, ("splice", "naive"), strict=True):
        pose = evaluator.pose(Splice("run", "carry_box", method=method), 1.0)  # type: ignore[arg-type]
        expected = np.empty((1, bank.skeleton.joint_count, 3), np.float32)
        evaluator.world_positions(pose, expected)
        assert np.abs(distances(shown) - distances(expected[0].astype(np.float64))).max() < 1e-4


def test_what_to_expect_of_the_pair_stands_on_the_stage(view: View, bank: Bank) -> None:
    known = expectation(Evaluator(bank), Splice("run", "wave"))
    assert known is not None
    readout = view.page.locator("#readout")
    view.show(locomotion="run", action="wave")
    expect(readout).to_contain_text(
        f"Expected error {100 * known.error:.0f} cm, plain replacement {100 * known.replaced:.0f} cm"
    )
    view.show(locomotion="run", action="wave", own="true")
    expect(readout).not_to_contain_text("Expected")


def test_the_action_as_captured_is_shown_at_the_moment_that_the_splice_plays(view: View, bank: Bank) -> None:
    view.show(locomotion="walk", action="wave", show="splice,action", time=1.5, layout="over")
    _, captured = joints(view)
    evaluator = Evaluator(bank)
    moment = evaluator.action_frames(Splice("walk", "wave"), np.array([1.5]))[0] / bank.clip("wave").rate
    expected = np.empty((1, bank.skeleton.joint_count, 3), np.float32)
    evaluator.world_positions(evaluator.pose(Splice("wave"), float(moment)), expected)
    assert np.abs(distances(captured) - distances(expected[0].astype(np.float64))).max() < 1e-3


def test_mirror_images_are_shown_of_the_action_the_locomotion_and_the_action_as_captured(
    view: View, bank: Bank
) -> None:
    view.show(locomotion="walk", action="wave", show="splice,action", time=1.5, layout="over")
    view.page.keyboard.press("x")
    view.page.get_by_role("checkbox", name="Mirror").nth(1).click()
    view.settle()
    assert chosen(view)["mirror"] == chosen(view)["mirror_locomotion"] == "true"
    shown, captured = joints(view)
    evaluator, expected = Evaluator(bank), np.empty((1, bank.skeleton.joint_count, 3), np.float32)
    splice = Splice("walk~mirror", "wave~mirror")
    evaluator.world_positions(evaluator.pose(splice, 1.5), expected)
    assert np.abs(distances(shown) - distances(expected[0].astype(np.float64))).max() < 1e-4
    moment = evaluator.action_frames(splice, np.array([1.5]))[0] / bank.clip("wave").rate
    evaluator.world_positions(evaluator.pose(Splice("wave~mirror"), float(moment)), expected)
    assert np.abs(distances(captured) - distances(expected[0].astype(np.float64))).max() < 1e-3


def test_both_sides_are_on_the_canvas_in_their_colours(view: View) -> None:
    view.show(action="wave", path="false", contacts="false")
    found: Any = view.run(
        """viewer.stage.draw();
        const { width, height } = viewer.stage.canvas;
        const copy = new OffscreenCanvas(width, height).getContext('2d');
        copy.drawImage(viewer.stage.canvas, 0, 0);
        const { data } = copy.getImageData(0, 0, width, height);
        let orange = 0, grey = 0;
        for (let at = 0; at < data.length; at += 4) {
            const [red, green, blue] = [data[at], data[at + 1], data[at + 2]];
            if (red > blue + 60 && red > green + 20) orange++;
            if (Math.abs(red - green) < 12 && Math.abs(green - blue) < 12 && red < 180) grey++;
        }
        return [orange, grey]"""
    )
    assert min(found) > 2000  # pixels


def test_distances_are_shown_in_centimetres(view: View) -> None:
    view.show(locomotion="run", action="wave", against="naive", time=1.0)
    text = view.page.locator("#readout .apart").inner_text()
    found = re.fullmatch(r"([\d.]+) cm from naive, at most ([\d.]+) cm at (\w+)", text)
    assert found, text
    assert 0.5 < float(found[1]) < float(found[2]) < 60.0


def test_keys_play_step_and_compare(view: View) -> None:
    view.open(action="wave", time=1.0)
    keyboard = view.page.keyboard
    keyboard.press("ArrowRight")
    assert abs(float(view.run("return player.time")) - (1.0 + 1 / 60)) < 1e-6  # type: ignore[arg-type]
    keyboard.press("Shift+ArrowLeft")
    assert abs(float(view.run("return player.time")) - (1.0 - 9 / 60)) < 1e-6  # type: ignore[arg-type]
    keyboard.press("Home")
    assert view.run("return player.time") == 0.0
    keyboard.press("Space")
    view.run(until("player.time > 0.1"))
    keyboard.press("Space")
    assert view.run("return state.values.playing") is False
    keyboard.press("2")
    keyboard.press("3")
    keyboard.press("b")
    view.settle()
    state = chosen(view)
    assert state["show"] == "splice,locomotion"
    assert state["layout"] == "over"
    keyboard.press("/")
    keyboard.type("carry")
    assert view.page.get_by_role("option").filter(visible=True).filter(has_text="carry_box").count() == 1


def test_a_range_is_repeated(view: View) -> None:
    view.show(action="wave", **{"from": 1, "to": 1.5}, time=1.0, playing="true", speed=2)
    times: Any = view.run(
        """const times = [];
        for (let n = 0; n < 40; n++) { await new Promise(requestAnimationFrame); times.push(player.time); }
        return times"""
    )
    assert 1.0 <= min(times) < max(times) <= 1.5
    assert any(later < before for before, later in pairwise(times))


def test_a_click_on_the_timeline_seeks(view: View) -> None:
    view.show(action="wave")
    box = view.page.locator("#timeline canvas").first.bounding_box()
    assert box is not None
    view.page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    assert 1.5 < float(view.run("return player.time")) < 3.5  # type: ignore[arg-type]


def test_controls_act_at_once(view: View, bank: Bank) -> None:
    view.show(locomotion="walk", action="wave", time=2.0, show="splice")
    before = joints(view)
    view.run("state.set({ mask: 'left_arm' })")
    view.settle()
    after = joints(view)
    right, left = bank.skeleton.names.index("RightHand"), bank.skeleton.names.index("LeftHand")
    assert np.linalg.norm(before[0, right] - after[0, right]) > 0.05
    assert np.linalg.norm(before[0, left] - after[0, left]) < 0.05
    view.run("state.set({ second: 'run', share: 0.5 })")
    view.settle()
    assert np.linalg.norm(joints(view)[0, 0] - after[0, 0]) > 0.3  # a mix with running is faster


def test_a_link_shows_the_same(view: View) -> None:
    view.open(locomotion="run", action="wave", time=1.25, layout="over", show="splice,locomotion", mask="arms")
    found, address = joints(view), view.page.url
    view.page.goto("about:blank")
    view.page.goto(address)
    view.settle()
    np.testing.assert_allclose(joints(view), found, atol=1e-5)


def test_values_of_a_link_that_make_no_sense_do_no_harm(view: View) -> None:
    view.open(locomotion="<b>x", action="nobody", time="soon", show="x,splice,constructor", speed="NaN", view="up")
    fault = view.page.locator("#readout .fault")
    assert view.run("return viewer.shown.map(({ name }) => name)") == ["splice"]
    assert view.run("return state.values.locomotion") == "walk"
    expect(fault).to_have_text('This bank has no clip "<b>x", "nobody". Choose another.')
    view.page.locator("#lists").get_by_role("option").filter(has_text="wave").click()
    expect(fault).to_have_text('This bank has no clip "<b>x". Choose another.')
    view.page.locator("#lists").get_by_role("option").filter(has_text="side_step").click()
    expect(fault).to_be_empty()
    view.page.goto(f"{view.url}/view/?action=wave&weight=7")
    expect(fault).to_contain_text("weight: expected a number from 0 to 1, found 7")
    view.faults.clear()  # the browser logs the answer 422


def test_it_says_why_nothing_is_shown_and_why_nothing_is_compared(view: View) -> None:
    view.show(action="wave")
    view.run("state.set({ show: '' })")
    expect(view.page.locator("#readout .fault")).to_have_text("There is nothing to show. Check a motion under Compare.")
    compare = view.page.locator(".group").filter(has_text="Distance to").locator("fieldset .hint")
    view.show(action="wave", against="locomotion")
    expect(compare).to_have_text("Check Locomotion alone to compare with it.")
    view.show(action="wave", truth="run")
    expect(compare).to_have_text("Check Truth to compare with it.")
    view.show(action="wave", against="splice")
    expect(compare).to_contain_text("choose the distance to another one")
    view.show(action="wave", against="naive")
    expect(compare).to_be_hidden()


def test_a_shorter_motion_is_shown_at_its_end_and_repeated_as_a_whole(view: View) -> None:
    view.show(action="wave", length=6, time=5, **{"from": 4, "to": 5.5})
    view.run("state.set({ length: 2 })")
    view.settle()
    assert view.run("return [player.time, ...player.range]") == [2, 0, 2]
    expect(view.page.get_by_role("textbox", name="Time")).to_have_value("2.00")


def test_buttons_go_to_the_ends_of_the_range_as_their_keys_do(view: View) -> None:
    view.show(action="wave", time=1.5, **{"from": 1, "to": 2})
    for button, key in (("First frame", "Home"), ("Last frame", "End")):
        view.page.get_by_role("button", name=button).click()
        found = view.run("return player.time")
        view.page.keyboard.press(key)
        assert view.run("return player.time") == found


def test_no_motion_hides_another_from_the_side(view: View) -> None:
    view.show(action="wave", view="side", show="splice,naive,locomotion")
    places: Any = view.run(
        """const { Vector3 } = await import('/view/vendor/three.js');
        const { camera } = viewer.stage;
        return viewer.show.aiming(state.values).map(({ body, offset }) => {
            const hips = new Vector3().fromArray(body.positions).add(new Vector3(...offset));
            return hips.project(camera).x;
        })"""
    )
    assert -0.9 < places[0] < places[1] - 0.2 < 0.7  # of the picture's width from -1 to 1


def test_the_picture_comes_back_when_the_graphics_card_was_reset(view: View) -> None:
    view.show(action="wave", time=1)
    found = view.run(
        """const { stage } = viewer;
        let drawn = 0;
        const draw = stage.draw;
        const lose = stage.canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
        const heard = (event) => new Promise((heard) => stage.canvas.addEventListener(event, heard));
        const lost = heard('webglcontextlost');
        lose.loseContext();
        await lost;
        stage.draw = () => { drawn++; draw.call(stage); };
        const restored = heard('webglcontextrestored');
        setTimeout(() => lose.restoreContext());
        await restored;
        delete stage.draw;
        return drawn"""
    )
    assert found


def test_the_arrow_goes_from_the_search_to_the_first_clip(view: View) -> None:
    view.show(action="wave")
    view.page.keyboard.press("/")
    view.page.keyboard.type("box")
    view.page.keyboard.press("ArrowDown")
    view.page.keyboard.press("Enter")
    view.settle()
    assert view.run("return state.values.action") == "carry_box"
    view.page.get_by_role("searchbox").fill("")


def test_it_does_not_move_by_itself_where_less_motion_is_wished(context: BrowserContext, service: Running) -> None:
    view = View(context.new_page(), service.url)
    view.page.emulate_media(reduced_motion="reduce")
    view.page.goto(f"{view.url}/view/?action=wave")
    view.settle()
    assert view.run("return [state.values.playing, player.time]") == [False, 0]
