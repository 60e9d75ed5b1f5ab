"""A browser with the page of a live service. Skipped where Chromium is not installed."""

from __future__ import annotations

from collections.abc import Iterator
from urllib.parse import urlencode

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

from bench.chromium import ARGUMENTS, CHROMIUM, MISSING
from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.service.running import Running, running


@pytest.fixture(scope="module")  # not longer: while it is open, other tests cannot run an event loop
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip(MISSING)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def service(bank: Bank) -> Iterator[Running]:
    """A ready service, which no test changes."""
    with running(bank.path, Settings()) as service:
        yield service


class View:
    """The page, and what went wrong on it."""

    def __init__(self, context: BrowserContext, url: str) -> None:
        self.page: Page = context.new_page()
        self.url = url
        self.faults: list[str] = []
        self.requests: list[str] = []
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("console", lambda said: self.faults.append(said.text) if said.type == "error" else None)
        self.page.on("request", lambda request: self.requests.append(request.url))

    def open(self, **state: object) -> None:
        """Opens the page with values of its state, paused unless they say otherwise."""
        values = {"playing": "false", **state}
        self.page.goto(f"{self.url}/view/?{urlencode(values)}")
        self.settle()

    def settle(self) -> None:
        """Waits until what the state says is shown."""
        self.run(
            """const end = performance.now() + 15_000;
            while (!viewer.isSettled || !viewer.shown.length) {
                if (performance.now() > end) throw new Error('the page does not show what its state says');
                await new Promise(requestAnimationFrame);
            }"""
        )

    def run(self, body: str) -> object:
        """Runs the body of a function that knows `state`, `player`, `viewer` and `sides`."""
        names = "{ state, player, viewer, sides }"
        return self.page.evaluate(f"async () => {{ const {names} = await import('/view/main.js'); {body} }}")


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport={"width": 1000, "height": 640}, accept_downloads=True)
    context.set_default_timeout(15_000)
    yield context
    context.close()


@pytest.fixture
def view(context: BrowserContext, service: Running) -> Iterator[View]:
    """The page in a new tab. No test may leave an error on it, or ask another host."""
    view = View(context, service.url)
    yield view
    assert not view.faults
    assert all(url.startswith((service.url, "blob:", "data:")) for url in view.requests)
