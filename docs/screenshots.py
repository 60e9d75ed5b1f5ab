"""Takes the pictures of the viewer for the documentation, in Chromium: part of `make pictures`."""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal
from urllib.parse import urlencode

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from bench.chromium import ARGUMENTS, CHROMIUM
from bench.service.process import serving

WIDE, PHONE = (1366, 768), (390, 844)
PICTURES: dict[str, tuple[tuple[int, int], Literal["light", "dark"], dict[str, object]]] = {
    "viewer": (WIDE, "light", {"locomotion": "curve", "action": "carry_cup", "time": 2.1}),
    "viewer-differences": (
        WIDE,
        "light",
        {"locomotion": "run", "action": "wave", "time": 1.7, "layout": "over", "against": "naive", "joint": "LeftArm"},
    ),
    "viewer-stairs": (
        WIDE,
        "dark",
        {
            "locomotion": "stairs_up",
            "action": "carry_box",
            "time": 3.2,
            "show": "splice,naive,action",
            "trails": "true",
        },
    ),
    "viewer-aim": (
        WIDE,
        "light",
        {
            "locomotion": "run",
            "action": "push",
            "time": 1.3,
            "show": "splice,locomotion",
            "look": "true",
            "chest": "true",
            "steady": "true",
            "point": "0.9 1.6 5.3",
        },
    ),
    "viewer-crowd": (WIDE, "light", {"crowd": 100}),
    "viewer-phone": (PHONE, "dark", {"locomotion": "walk", "action": "wave", "time": 1.0, "show": "splice"}),
}
ANIMATED = {"locomotion": "curve", "action": "carry_cup", "against": "", "trails": "true"}
FROM, SECONDS, RATE = 1.0, 3.2, 15  # of the animation


def take_screenshots(bank: Path, images: Path) -> None:
    """Writes all pictures of the viewer that shows a bank of the built-in motions, which takes minutes."""
    report = bank.parent / "quality"
    command = [sys.executable, "-m", "bench.quality", "--bank", str(bank), "--out", str(report)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with serving(bank, "--report", str(report / "scores.json")) as service, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        for name, (size, scheme, state) in PICTURES.items():
            with page(browser, service.url, size, scheme, state) as shown:
                if "joint" in state:
                    shown.get_by_role("button", name="Curves of a joint").click()
                shown.wait_for_timeout(1000)
                Image.open(io.BytesIO(shown.screenshot())).convert("RGB").save(images / f"{name}.png", optimize=True)
        shown = browser.new_page(viewport={"width": WIDE[0], "height": WIDE[1]})
        shown.goto(f"{service.url}/view/report")
        shown.wait_for_timeout(2000)
        Image.open(io.BytesIO(shown.screenshot())).convert("RGB").save(images / "viewer-report.png", optimize=True)
        animate(browser, service.url, images / "viewer.webp")
        browser.close()


def animate(browser: Browser, url: str, path: Path) -> None:
    """Writes the animation with which the README begins."""
    pictures = []
    with page(browser, url, (1180, 760), "light", ANIMATED) as shown:
        for number in range(round(SECONDS * RATE)):
            shown.evaluate(
                """async (time) => {
                    const { player } = await import('/view/main.js');
                    player.seek(time);
                    await new Promise(requestAnimationFrame);
                    await new Promise(requestAnimationFrame);
                }""",
                FROM + number / RATE,
            )
            area = shown.locator("main").bounding_box()
            assert area is not None
            picture = Image.open(io.BytesIO(shown.screenshot(clip=area)))  # type: ignore[arg-type]
            pictures.append(picture.convert("RGB").resize((720, round(720 * picture.height / picture.width))))
    first, *rest = pictures
    first.save(path, save_all=True, append_images=rest, duration=round(1000 / RATE), loop=0, quality=70, method=6)


@contextmanager
def page(
    browser: Browser, url: str, size: tuple[int, int], scheme: Literal["light", "dark"], state: dict[str, object]
) -> Iterator[Page]:
    """Opens the viewer, and waits until it shows a state."""
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
    shown = context.new_page()
    shown.goto(f"{url}/view/?{urlencode({'playing': 'false', **state})}")
    shown.evaluate(
        """async () => {
            const { viewer } = await import('/view/main.js');
            const isReady = () => viewer.crowd?.shown || (viewer.isSettled && viewer.shown.length);
            while (!isReady()) await new Promise(requestAnimationFrame);
        }"""
    )
    yield shown
    context.close()
