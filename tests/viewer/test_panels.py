"""What surrounds the stage: tokens, lost services, exports, narrow screens, names that are no names."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Route, expect
from pydantic import SecretStr

from motionsplice.motion.formats.reading import read_clip
from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.service.running import Running, running
from tests.viewer.conftest import View

AIMING = {"look": "true", "right_arm": "true", "lock_feet": "true", "point": "1 1.5 4"}


@pytest.mark.parametrize(("button", "suffix"), [("BVH", "bvh"), ("GLB", "glb")])
def test_a_splice_is_exported(view: View, tmp_path: Path, button: str, suffix: str) -> None:
    view.open(locomotion="run", action="wave")
    view.page.get_by_role("button", name="Export").click()
    with view.page.expect_download() as waiting:
        view.page.get_by_role("button", name=button, exact=True).click()
    assert waiting.value.suggested_filename == f"run+wave.{suffix}"
    path = tmp_path / f"x.{suffix}"
    waiting.value.save_as(path)
    clip = read_clip(path).clip
    assert (clip.frame_count, round(clip.rate)) == (181, 60)


def test_a_picture_is_saved(view: View, tmp_path: Path) -> None:
    view.open(action="wave")
    with view.page.expect_download() as waiting:
        view.page.keyboard.press("s")
    waiting.value.save_as(tmp_path / "x.png")
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")


def test_the_python_lines_give_the_same_motion(view: View, bank: Bank, tmp_path: Path) -> None:
    view.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    view.open(locomotion="run", action="wave", at=0.5, when="foot", mask="arms", blend=0.2, **AIMING)
    view.page.get_by_role("button", name="Export").click()
    view.page.get_by_role("button", name="Python").click()
    expect(view.page.get_by_text("on the clipboard")).to_be_visible()
    program = str(view.page.evaluate("navigator.clipboard.readText()"))
    (tmp_path / "bank").symlink_to(bank.path)
    (tmp_path / "lines.py").write_text(program)
    done = subprocess.run([sys.executable, "lines.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, program + done.stderr
    order = json.dumps(view.run("return viewer.shown[0].take")).encode()
    url, kind = f"{view.url}/v1/take?format=bvh", {"content-type": "application/json"}
    expected = urllib.request.urlopen(urllib.request.Request(url, order, kind)).read()
    assert (tmp_path / "run+wave.bvh").read_bytes() == expected


def test_a_link_with_the_moment_is_copied(view: View) -> None:
    view.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    view.open(locomotion="run", action="wave", time=1.5)
    view.page.keyboard.press("u")
    expect(view.page.get_by_text("on the clipboard").first).to_be_visible()
    link = str(view.page.evaluate("navigator.clipboard.readText()"))
    assert "time=1.5" in link
    assert "action=wave" in link


def test_the_token_is_asked_for_and_kept_out_of_the_address(browser: Browser, bank: Bank) -> None:
    with running(bank.path, Settings(token=SecretStr("secret-token"))) as guarded:
        context = browser.new_context()
        view = View(context.new_page(), guarded.url)
        view.page.goto(f"{guarded.url}/view/?action=wave&playing=false")
        field = view.page.get_by_role("textbox", name="Token")
        field.fill("wrong-token")
        field.press("Enter")
        expect(view.page.get_by_text("does not accept this token")).to_be_visible()
        field.fill("secret-token")
        field.press("Enter")
        expect(field).to_be_hidden()
        view.settle()
        view.page.reload()
        view.settle()  # the tab remembers it
        assert not [url for url in view.requests if "secret" in url]
        assert "secret" not in view.page.url
        context.close()


def test_it_says_when_the_service_is_gone_and_comes_back(browser: Browser, bank: Bank) -> None:
    context = browser.new_context()
    with running(bank.path, Settings()) as first:
        view = View(context.new_page(), first.url)
        view.open(action="wave")
    view.run("state.set({ action: 'carry_box' })")
    banner = view.page.locator("#banner")
    expect(banner).to_contain_text("does not answer")
    with running(bank.path, Settings(), first.port):
        expect(banner).to_contain_text("is back", timeout=30_000)
        view.settle()
        assert view.run("return viewer.shown[0].take.commands[1].action") == "carry_box"
    context.close()


def test_it_waits_for_a_service_that_compiles_its_kernels(view: View) -> None:
    refusals = iter(["not-ready", "not-ready"])

    def answer(route: Route) -> None:
        if (kind := next(refusals, None)) is None:
            route.fallback()
        else:
            problem = {"type": f"urn:motionsplice:{kind}", "detail": "the kernels are still being compiled"}
            route.fulfill(status=503, json=problem)

    view.page.route("**/v1/take*", answer)
    view.page.goto(f"{view.url}/view/?action=wave&show=splice&playing=false")
    expect(view.page.locator("#readout .fault")).to_contain_text("the kernels are still being compiled")
    view.settle()
    expect(view.page.locator("#readout .fault")).to_be_empty()
    view.faults.clear()  # the browser logs the answers 503


def test_it_says_which_clips_another_bank_lacks(view: View) -> None:
    view.open(locomotion="run", action="wave")

    def exchange(route: Route) -> None:
        found = json.loads(route.fetch().text())
        if isinstance(found, list):
            route.fulfill(json=[clip for clip in found if clip["name"] not in ("run", "wave")])
        else:
            route.fulfill(json={**found, "bank": "0" * 32})

    view.page.route(re.compile("/v1/(clips|server)$"), exchange)
    view.page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")  # else it looks every five seconds
    expect(view.page.locator("#readout .fault")).to_have_text('This bank has no clip "run", "wave". Choose another.')
    view.settle()
    assert view.run("return viewer.shown[0].take.commands[0].locomotion") == "walk"


def test_without_webgl_it_says_what_to_do(context: BrowserContext, service: Running) -> None:
    page = context.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(f"{service.url}/view/?action=wave")
    expect(page.locator("#banner")).to_contain_text("does not offer WebGL 2")
    expect(page.locator("#banner")).to_contain_text("Turn on its hardware acceleration")


def test_long_names_can_be_told_apart(view: View) -> None:
    name = "walk_forward_relaxed_with_a_heavy_backpack_take_003"
    view.page.route("**/v1/clips", lambda route: route.fulfill(body=route.fetch().text().replace("side_step", name)))
    view.open()
    row = view.page.get_by_role("option").filter(has_text=name).locator(".name")
    assert row.evaluate("(one) => one.scrollWidth <= one.clientWidth && one.scrollHeight <= one.clientHeight")


def test_names_are_text(view: View, service: Running) -> None:
    hostile = "<img src=x onerror=alert(1)>"

    def rename(route: Route) -> None:
        clips = json.loads(route.fetch().text().replace("side_step", hostile))
        clips[0]["tags"], clips[0]["warnings"] = [hostile], [hostile]
        route.fulfill(json=clips)

    view.page.route("**/v1/clips", rename)
    view.page.on("dialog", lambda dialog: view.faults.append(dialog.message))
    view.open()
    assert view.page.locator("img").count() == 0
    expect(view.page.locator("#lists").get_by_text(hostile).first).to_be_visible()


@pytest.mark.parametrize(("width", "height"), [(390, 844), (800, 600), (1366, 768)])
def test_nothing_is_cut_off(view: View, width: int, height: int) -> None:
    view.page.set_viewport_size({"width": width, "height": height})
    view.open(action="wave")
    assert view.page.evaluate("document.documentElement.scrollWidth") <= width
    box = view.page.locator("#stage").bounding_box()
    assert box is not None
    assert box["width"] >= 0.5 * min(width, 900)
    assert box["height"] >= 200.0
    if width < 900:
        view.page.get_by_role("button", name="Clips").click()
        view.page.locator("#lists").get_by_role("option").filter(has_text="carry_box").click()
        view.settle()
        assert view.run("return state.values.action") == "carry_box"


@pytest.mark.parametrize(("width", "height"), [(1024, 640), (844, 390)])
def test_plots_can_be_reached_on_a_low_screen(view: View, width: int, height: int) -> None:
    view.page.set_viewport_size({"width": width, "height": height})
    view.open(action="wave", joint="RightHand", against="naive")
    view.page.get_by_role("button", name="Curves of a joint").click()
    view.page.locator("main").evaluate("(main) => main.scrollTo(0, 1e5)")
    box = view.page.locator("#curves canvas").last.bounding_box()
    assert box is not None
    assert box["y"] + box["height"] < height + 1
