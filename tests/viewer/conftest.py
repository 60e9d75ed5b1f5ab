"""A browser with the page of a live service. Skipped where Chromium is not installed."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlencode

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, ViewportSize, expect, sync_playwright

from bench.chromium import ARGUMENTS, CHROMIUM, MISSING
from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.service.running import Running, running

# The picture is drawn again at the end, because the state may have had this time before.
SHOW = """const { values } = new State(new URLSearchParams(QUERY));
    const { time, playing } = values;
    state.set({ ...values, time: player.time, playing: false });
    do await new Promise(requestAnimationFrame); while (!viewer.isSettled); // so that the duration is right
    player.seek(time);
    state.set({ playing });
    viewer.view.onchange();"""
SIZE: ViewportSize = {"width": 1000, "height": 640}
PATIENCE = 60_000.0  # milliseconds, far more than any step takes, also on a machine that is busy


@pytest.fixture(scope="module")  # not longer: while it is open, other tests cannot run an event loop
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip(MISSING)
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def service(bank: Bank) -> Iterator[Running]:
    """A ready service, which no test changes."""
    with running(bank.path, Settings()) as service:
        yield service


class View:
    """The page in a tab, and what went wrong on it."""

    def __init__(self, page: Page, url: str) -> None:
        self.page = page
        self.url = url
        self.faults: list[str] = []
        self.requests: list[str] = []
        self._listeners: dict[Any, Callable[[Any], None]] = {
            "pageerror": lambda error: self.faults.append(str(error)),
            "console": lambda said: self.faults.append(said.text) if said.type == "error" else None,
            "request": lambda request: self.requests.append(request.url),
        }
        for event, listener in self._listeners.items():
            page.on(event, listener)

    def leave(self) -> None:
        """Leaves the tab to others."""
        for event, listener in self._listeners.items():
            self.page.remove_listener(event, listener)
        self.page.unroute_all()
        self.page.set_viewport_size(SIZE)

    def open(self, **state: object) -> None:
        """Loads the page with values of its state, paused unless they say otherwise."""
        self.page.goto(f"{self.url}/view/?{urlencode({'playing': 'false', **state})}")
        self.settle()

    def show(self, **state: object) -> None:
        """Shows what `open` would, in the page that is there, because loading one takes seconds."""
        if not self.page.url.startswith(f"{self.url}/view/?"):
            self.open(**state)
            return
        query = json.dumps(urlencode({"playing": "false", "locomotion": "walk", **state}))
        self.run(f"const {{ State }} = await import('/view/state.js'); {SHOW.replace('QUERY', query)}")
        self.settle()

    def settle(self) -> None:
        """Waits until what the state says is shown."""
        self.run(until("viewer.isSettled && viewer.shown.length"))

    def run(self, body: str) -> object:
        """Runs the body of a function that knows `state`, `player`, `viewer` and `sides`."""
        names = "{ state, player, viewer, sides }"
        return self.page.evaluate(f"async () => {{ const {names} = await import('/view/main.js'); {body} }}")


def until(condition: str) -> str:
    """Returns statements for `View.run` that wait until a condition holds, and fail after PATIENCE."""
    return f"""const end = performance.now() + {PATIENCE};
    while (!({condition})) {{
        if (performance.now() > end) throw new Error({json.dumps(f"{condition} did not come true")});
        await new Promise((resolve) => setTimeout(resolve, 20));
    }}"""


@contextmanager
def new_context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport=SIZE)
    context.set_default_timeout(PATIENCE)
    yield context
    context.close()


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    """A browser that remembers nothing of other tests."""
    with new_context(browser) as context:
        yield context


@pytest.fixture(scope="module")
def tab(browser: Browser) -> Iterator[Page]:
    """The tab that the tests of a module share."""
    with new_context(browser) as context:
        yield context.new_page()


@pytest.fixture
def view(tab: Page, service: Running) -> Iterator[View]:
    """The page in the module's tab. No test may leave an error on it, or ask another host."""
    view = View(tab, service.url)
    yield view
    view.leave()
    assert not view.faults
    assert all(url.startswith((service.url, "blob:", "data:")) for url in view.requests)
