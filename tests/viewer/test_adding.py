"""New clips: files that are dropped on the lists."""

from __future__ import annotations

import base64
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Locator, Page, expect
from pydantic import SecretStr

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.service.running import Running, running
from tests.viewer.conftest import View

TOKEN = "secret-token"
JOB = 90_000  # ms in which the offline job is done
DROP = """(target, files) => {
    const dropped = new DataTransfer();
    for (const [name, data] of files)
        dropped.items.add(new File([Uint8Array.from(atob(data), (one) => one.charCodeAt(0))], name));
    for (const type of ['dragenter', 'dragover', 'drop'])
        target.dispatchEvent(new DragEvent(type, { dataTransfer: dropped, bubbles: true, cancelable: true }));
}"""


@pytest.fixture
def folder(clip_folder: Path, bank: Bank, tmp_path: Path) -> Path:
    """A folder of clips beside the bank built from it, which tests change."""
    shutil.copytree(clip_folder, tmp_path / "clips")
    shutil.copytree(bank.path, tmp_path / "bank")
    return tmp_path


@pytest.fixture
def open_service(folder: Path) -> Iterator[Running]:
    settings = Settings(token=SecretStr(TOKEN), clips=folder / "clips", max_upload=3_000_000)
    with running(folder / "bank", settings) as service:
        yield service


@pytest.fixture
def view(context: BrowserContext, open_service: Running) -> View:
    context.add_init_script(f"sessionStorage.setItem('motionsplice-token', '{TOKEN}')")
    view = View(context.new_page(), open_service.url)
    view.open()
    return view


def drop(view: View, **files: bytes) -> None:
    """Drops files on the column of lists. `__` in a name stands for the dot."""
    named = [(name.replace("__", "."), base64.b64encode(data).decode()) for name, data in files.items()]
    view.page.locator("#lists-column").evaluate(DROP, named)


def upload(page: Page, name: str) -> Locator:
    return page.get_by_role("list", name="Files on their way").get_by_role("listitem").filter(has_text=name)


def test_a_dropped_file_is_offered_and_played(view: View, folder: Path) -> None:
    page = view.page
    drop(view, Greet__BVH=dump_bvh(make("walk", "wave", seed=21, seconds=3.0)))
    dialog = page.get_by_role("dialog", name="Add clips")
    expect(dialog.get_by_label("Name")).to_have_value("Greet")
    dialog.get_by_label("Name").fill("greet")
    dialog.get_by_label("Kind").select_option("action")
    dialog.get_by_label("Tags").fill("friendly, new")
    dialog.get_by_role("button", name="Add").click()
    expect(upload(page, "greet.bvh")).to_contain_text("In the bank", timeout=JOB)
    option = page.get_by_role("listbox", name="Actions").get_by_role("option", name="greet")
    expect(option).to_have_attribute("aria-selected", "true")
    expect(option).to_contain_text("friendly · new")
    view.settle()
    assert view.run("return [state.values.action, state.values.playing, viewer.shown[0].name]") == [
        "greet",
        True,
        "splice",
    ]
    assert (folder / "clips" / "greet.bvh").exists()
    assert TOKEN not in page.url
    assert not view.faults


def test_files_are_sent_in_turn_and_refusals_are_readable(view: View, folder: Path) -> None:
    page = view.page
    drop(view, bad__bvh=b"HIERARCHY nonsense", jog__bvh=dump_bvh(make("run", seed=20, seconds=3.0)), picture__png=b"x")
    dialog = page.get_by_role("dialog", name="Add clips")
    expect(dialog).to_contain_text("picture.png")
    expect(dialog).to_contain_text("Not a motion file")
    dialog.get_by_role("button", name="Add 2 clips").click()
    expect(upload(page, "bad.bvh")).to_contain_text("bad.bvh, line 1: the file ends inside the hierarchy", timeout=JOB)
    expect(upload(page, "jog.bvh")).to_contain_text("In the bank", timeout=JOB)
    expect(page.locator("#lists").get_by_role("option", name="jog")).to_have_attribute("aria-selected", "true")
    upload(page, "bad.bvh").get_by_role("button", name="Remove").click()
    expect(upload(page, "bad.bvh")).to_have_count(0)
    assert not (folder / "clips" / "bad.bvh").exists()


def test_a_job_that_cannot_start_is_readable(view: View, folder: Path) -> None:
    (folder / "clips" / "run.bvh").unlink()
    drop(view, jog__bvh=dump_bvh(make("run", seed=20, seconds=3.0)))
    view.page.get_by_role("dialog").get_by_role("button", name="Add").click()
    expect(upload(view.page, "jog.bvh")).to_contain_text(
        "the folder does not have these clips of the bank: run", timeout=JOB
    )


def test_a_lost_connection_is_readable_and_the_file_can_be_sent_again(view: View) -> None:
    page = view.page
    page.route("**/v1/clips?*", lambda route: route.abort())
    drop(view, jog__bvh=dump_bvh(make("run", seed=20, seconds=3.0)))
    page.get_by_role("dialog").get_by_role("button", name="Add").click()
    expect(upload(page, "jog.bvh")).to_contain_text("The connection was lost while the file was sent")
    page.unroute("**/v1/clips?*")
    page.route("**/v1/job/events", lambda route: route.abort(), times=1)
    upload(page, "jog.bvh").get_by_role("button", name="Try again").click()
    expect(upload(page, "jog.bvh")).to_contain_text("In the bank", timeout=JOB)


def test_names_are_checked_before_anything_is_sent(view: View) -> None:
    page = view.page
    jog = dump_bvh(make("run", seed=20, seconds=3.0))
    drop(view, walk__bvh=jog, big__bvh=b" " * 3_000_001)
    dialog = page.get_by_role("dialog", name="Add clips")
    expect(dialog).to_contain_text("Replaces the clip walk, for everyone.")
    expect(dialog).to_contain_text("The file has 3 MB, and this service takes at most 3 MB.")
    dialog.get_by_label("Name").fill("a/b")
    dialog.get_by_role("button", name="Add").click()
    expect(dialog).to_be_visible()  # the browser says what is wrong
    dialog.get_by_role("button", name="Cancel").click()
    expect(dialog).to_be_hidden()
    assert not any("/v1/clips?" in url for url in view.requests)


def test_without_uploads_nothing_is_offered(context: BrowserContext, service: Running) -> None:
    view = View(context.new_page(), service.url)
    view.open(action="wave")
    expect(view.page.locator("#adding")).to_contain_text(
        "To add clips here, start the service with --clips FOLDER and a --token."
    )
    assert view.page.get_by_role("button", name="Add clips").count() == 0
    drop(view, jog__bvh=b"HIERARCHY")
    assert view.page.get_by_role("dialog").count() == 0
    assert not view.faults
