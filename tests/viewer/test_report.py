"""The page of what bench.quality found."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlparse

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.reports import report_of
from tests.service.running import Running, running
from tests.viewer.conftest import View


@pytest.fixture(scope="module")
def report_file(bank: Bank, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("quality") / "scores.json"
    file.write_text(json.dumps(report_of(bank)))
    return file


@pytest.fixture(scope="module")
def reporting(bank: Bank, report_file: Path) -> Iterator[Running]:
    with running(bank.path, Settings(report=report_file)) as service:
        yield service


@pytest.fixture
def view(tab: Page, reporting: Running) -> Iterator[View]:
    view = View(tab, reporting.url)
    view.page.goto(f"{view.url}/view/report")
    expect(view.page.get_by_role("heading", name="Pairs")).to_be_visible()
    yield view
    view.leave()
    assert not view.faults
    assert all(url.startswith((reporting.url, "blob:", "data:")) for url in view.requests)


def rows(view: View) -> list[str]:
    """Returns locomotion and action of each row that is shown."""
    names = view.page.locator(".pairs tbody tr").all()
    return [f"{row.locator('th').inner_text()} <- {row.locator('td').first.inner_text()}" for row in names]


def test_the_viewer_links_to_it_only_if_there_is_a_report(
    view: View, context: BrowserContext, service: Running
) -> None:
    view.open(action="wave")
    view.page.get_by_role("link", name="Quality").click()
    expect(view.page.get_by_role("heading", name="Pairs")).to_be_visible()
    view.page.get_by_role("link", name="Viewer").click()
    expect(view.page.locator("#stage")).to_be_visible()
    other = View(context.new_page(), service.url)
    other.open(action="wave")
    expect(other.page.get_by_role("link", name="API")).to_be_visible()
    assert other.page.get_by_role("link", name="Quality").count() == 0


def test_a_click_on_a_pair_opens_the_viewer_at_its_worst_moment(view: View, report_file: Path) -> None:
    pair = next(one for one in json.loads(report_file.read_text())["pairs"] if one["truth"] == "walk")
    view.page.get_by_role("link", name="walk + wave: worst at").click()
    view.page.wait_for_url("**/view/?*")
    view.settle()
    assert view.run("return player.time") == pytest.approx(pair["worst"]["time"], abs=1e-3)
    assert view.run("return viewer.shown.map(({ name }) => name)") == ["splice", "naive", "truth"]
    text = view.page.locator("#readout .apart").inner_text()
    assert "from truth" in text
    assert float(text.split(" cm")[0]) == pytest.approx(pair["worst"]["value"], abs=0.06)  # both measure the same
    view.page.go_back()
    expect(view.page.get_by_role("heading", name="Pairs")).to_be_visible()


def test_a_click_on_a_curve_opens_the_moment_under_the_pointer(view: View) -> None:
    curve = view.page.locator(".pairs tbody tr").filter(has=view.page.get_by_role("link", name="walk + wave: worst at"))
    box = curve.locator(".strip").bounding_box()
    assert box is not None
    view.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 5)
    view.page.mouse.down()
    view.page.mouse.up()
    view.page.wait_for_url("**/view/?*")
    assert float(parse_qs(urlparse(view.page.url).query)["time"][0]) == pytest.approx(2.5, abs=0.1)


def test_pairs_are_sorted_and_filtered_and_the_address_keeps_it(view: View) -> None:
    assert len(rows(view)) == 3
    view.page.get_by_role("button", name="Locomotion").click()
    assert rows(view) == ["run <- carry_box", "run <- wave", "walk <- wave"]
    view.page.get_by_role("button", name="Locomotion").click()
    assert rows(view)[0] == "walk <- wave"
    expect(view.page.get_by_role("columnheader", name="Locomotion")).to_have_attribute("aria-sort", "descending")
    view.page.get_by_role("combobox", name="Filter by clip").fill("run wave")
    assert rows(view) == ["run <- wave"]
    expect(view.page.get_by_role("status")).to_contain_text("1 of 3 pairs")
    view.page.reload()
    expect(view.page.get_by_role("heading", name="Pairs")).to_be_visible()
    assert rows(view) == ["run <- wave"]


def test_targets_are_shown_as_met_or_missed(view: View, report_file: Path) -> None:
    targets = json.loads(report_file.read_text())["targets"]
    assert view.page.get_by_text("✓ met").count() == sum(one["met"] for one in targets)
    assert view.page.get_by_text("✗ missed").count() == sum(not one["met"] for one in targets)


def test_it_fits_on_a_phone(view: View) -> None:
    view.page.set_viewport_size({"width": 390, "height": 844})
    assert view.page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_report_of_another_bank_is_marked(
    context: BrowserContext, bank: Bank, report_file: Path, tmp_path: Path
) -> None:
    other, numbers = tmp_path / "other.json", json.loads(report_file.read_text())
    numbers["pairs"][0]["locomotion"] = "<b>x"
    other.write_text(json.dumps({**numbers, "bank": "0" * 32}))
    with running(bank.path, Settings(report=other)) as service:
        view = View(context.new_page(), service.url)
        view.page.goto(f"{service.url}/view/report")
        expect(view.page.get_by_role("alert")).to_contain_text(f"of another bank, {'0' * 32}")
        row = view.page.locator(".pairs tbody tr").filter(has_text="<b>x")
        assert row.count() == 1
        assert row.get_by_role("link").count() == 0  # the bank has no such clip
        assert not view.faults


def test_without_a_report_the_page_says_how_to_make_one(context: BrowserContext, service: Running) -> None:
    view = View(context.new_page(), service.url)
    view.page.goto(f"{service.url}/view/report")
    expect(view.page.get_by_role("heading", name="No report")).to_be_visible()
    expect(view.page.locator("pre")).to_contain_text("motionsplice serve BANK --report quality/scores.json")
