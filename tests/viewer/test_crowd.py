"""A crowd: characters of the WebSocket instead of the splice, and what they cost."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.service.running import Running, eventually, running
from tests.viewer.conftest import View, until


def gather(view: View, count: int, **state: object) -> None:
    """Opens the page with a crowd, and waits until all of it is there."""
    view.page.goto(f"{view.url}/view/?crowd={count}" + "".join(f"&{key}={value}" for key, value in state.items()))
    wait(view, f"viewer.crowd?.shown === {count}")


def wait(view: View, condition: str) -> None:
    view.run(until(condition))


def values(view: View) -> dict[str, str]:
    """Returns the figures of the panel."""
    found: Any = view.page.locator("#crowd dl > div").evaluate_all(
        "(all) => all.map((one) => [...one.children].map((c) => c.textContent))"
    )
    return dict(found)


def test_a_crowd_moves_and_says_what_it_costs(view: View) -> None:
    gather(view, 10)
    expect(view.page.locator("#transport")).to_be_hidden()
    expect(view.page.locator("#timeline")).to_be_hidden()
    wait(view, "parseInt(document.querySelector('#crowd dl').textContent.split('Frames')[1]) > 0")
    found = values(view)  # bounds that a machine of any speed keeps
    assert found["Characters"] == "10"
    assert 1 <= int(found["Frames"].split()[0]) <= 70
    assert int(found["Pictures"].split()[0]) >= 1
    assert 0.0 < float(found["Script"].split()[0]) <= float(found["Worst"].split()[0])
    assert int(found["Delay"].split()[0]) >= 10
    assert int(found["Traffic"].split()[0]) >= 1
    view.run(
        f"""const {{ characters }} = viewer.crowd?.company.connection;
        const turns = () => [...characters.values()].map((one) => [...one.pose().rotations]);
        const before = turns();
        const moved = (one, index) => Math.max(...one.map((value, at) => Math.abs(value - before[index][at])));
        {until("Math.min(...turns().map(moved)) > 1e-3")}"""
    )


def test_it_grows_shrinks_and_ends(view: View, service: Running) -> None:
    gather(view, 1)
    view.page.keyboard.press("n")
    wait(view, "viewer.crowd?.shown === 10")
    view.page.get_by_role("radiogroup", name="Characters").get_by_role("radio", name="100", exact=True).check()
    wait(view, "viewer.crowd?.shown === 100")
    view.run("state.set({ crowd: 3 })")
    wait(view, "viewer.crowd?.shown === 3 && viewer.crowd?.company.connection.characters.size === 3")
    view.page.get_by_role("button", name="End").click()
    view.settle()
    expect(view.page.locator("#crowd")).to_be_hidden()
    expect(view.page.locator("#transport")).to_be_visible()
    assert view.run("return viewer.shown.map(({ name }) => name)") == ["splice"]
    eventually(lambda: not service.config.front.shared.streams)


def test_a_link_shows_the_same_crowd(view: View) -> None:
    cast = (
        "return viewer.crowd?.company.members.map(({ locomotion, action, heading }) => [locomotion, action, heading])"
    )
    gather(view, 10)
    found: Any = view.run(cast)
    assert len({tuple(one) for one in found}) > 5
    view.page.goto("about:blank")
    gather(view, 10)
    assert view.run(cast) == found


def test_choosing_a_clip_ends_it_and_the_camera_is_that_of_the_splice(view: View) -> None:
    view.show(action="wave")
    camera = "return viewer.stage.camera.position.toArray().map((value) => Number(value.toFixed(3)))"
    before = view.run(camera)
    view.run("state.set({ crowd: 10 })")
    wait(view, "viewer.crowd?.shown === 10")
    assert view.run(camera) != before
    view.page.locator("#lists").get_by_role("option").filter(has_text="carry_box").click()
    view.settle()
    assert view.run("return [state.values.crowd, state.values.action]") == [0, "carry_box"]
    assert view.run(camera) == before


def test_its_colours_are_on_the_canvas(view: View) -> None:
    gather(view, 10)
    found: Any = view.run(
        """viewer.crowd?.picture();
        const { width, height } = viewer.stage.canvas;
        const copy = new OffscreenCanvas(width, height).getContext('2d');
        copy.drawImage(viewer.stage.canvas, 0, 0);
        const { data } = copy.getImageData(0, 0, width, height);
        let coloured = 0;
        for (let at = 0; at < data.length; at += 4) {
          const pixel = data.slice(at, at + 3);
          coloured += Math.max(...pixel) - Math.min(...pixel) > 60;
        }
        return coloured"""
    )
    assert found > 2000


@pytest.fixture
def small(bank: Bank, tab: Page) -> Iterator[View]:
    """The page of a service that allows five characters."""
    with running(bank.path, Settings(max_characters=5)) as service:
        view = View(tab, service.url)
        yield view
        view.leave()


def test_a_refusal_is_shown(small: View) -> None:
    small.page.goto(f"{small.url}/view/?crowd=10")
    expect(small.page.locator("#crowd .fault")).to_contain_text("more than 5")
    assert small.page.get_by_role("radiogroup", name="Characters").inner_text().split() == ["Characters", "Off", "1"]
    small.run("state.set({ crowd: 1 })")
    wait(small, "viewer.crowd?.shown === 1")
    expect(small.page.locator("#crowd .fault")).to_be_hidden()
    assert not small.faults
