"""Measures the viewer's page in Chromium: `python -m bench.speed.viewer [BANK] [--seconds 5] [--check]`.

Serves BANK, or a bank of the built-in motions, and opens /view. The calls that draw are left out, as the machine may
have no graphics card: what is measured is the page's script, and what it waits for. --check exits with status 1 if a
figure misses its target.

page            kilobytes of all files that the page loads, compressed as they are sent
first picture   milliseconds from navigation to the second moment that is drawn, in a browser without a cache
click           milliseconds from a click on another clip to the end of the script of its first picture: by a hand that
                clicks at once, and by one that points at the clip for 100 ms, which is enough to fetch it
seek            milliseconds from a click on the timeline to the end of the script of its picture
script          milliseconds of script for a picture: of a splice beside the naive one, and of crowds
all script      the same, with the frames that arrive, the garbage and all else: the whole time divided by pictures
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from playwright.sync_api import Browser, Page, sync_playwright

from bench.chromium import ARGUMENTS, CHROMIUM, MISSING
from bench.findings import Findings
from bench.service.banks import built_in
from bench.service.process import serving
from motionsplice.cli import run

SIZE = {"width": 1366, "height": 768}
NAVIGATIONS = 5
CLICKS = 20
CROWDS = (1, 100, 1000)
PATIENCE = 30.0  # seconds
SETTLING = 3000.0  # ms before the script of a crowd is measured

# Leaves out drawing, and notes each picture: when its script began and ended, and what it shows.
WATCH = """
for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced']) {
  WebGL2RenderingContext.prototype[name] = () => {};
}
window.pictures = [];
window.clicked = 0;
addEventListener('pointerdown', ({ timeStamp }) => { window.clicked = timeStamp; }, true);
const request = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (callback) => request((now) => {
  const began = performance.now();
  const { viewer, player } = window.page ?? {};
  const before = viewer?.drawn;
  callback(now);
  if (!viewer || viewer.drawn === before) return;
  const sides = viewer.shown.map(({ take }) => JSON.stringify(take)).join();
  window.pictures.push({ began, ended: performance.now(), time: player.time, sides });
});
addEventListener('DOMContentLoaded', async () => {
  window.page = await import('/view/main.js');
  const { viewer } = window.page;
  const draw = viewer.stage.draw.bind(viewer.stage);
  viewer.drawn = 0;
  viewer.stage.draw = () => { viewer.drawn += 1; draw(); };
});
"""

NEXT = "window.pictures.find(({ began, sides }) => began > window.clicked"
SENT = """performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation'))
.filter(({ name }) => name.includes('/view/')).reduce((sum, { encodedBodySize }) => sum + encodedBodySize, 0)"""


def until(page: Page, value: str) -> float:
    """Waits until a value is neither 0, false, undefined nor NaN, and returns it. The page's policy forbids `eval`."""
    found: Any = page.evaluate(
        f"async () => {{ for (const end = performance.now() + {1000.0 * PATIENCE};;) {{ const value = {value};"
        "if (value) return Number(value);"
        f"if (performance.now() > end) throw new Error('never: ' + {value!r});"
        "await new Promise((resolve) => setTimeout(resolve, 20)); } }"
    )
    return float(found)


@contextmanager
def opened(browser: Browser, url: str, query: str) -> Iterator[Page]:
    """Opens the page in a new context, without a cache, and waits until something moves."""
    context = browser.new_context(viewport=SIZE)  # type: ignore[arg-type]
    page = context.new_page()
    page.add_init_script(WATCH)
    page.goto(f"{url}/view/?{query}")
    until(page, "window.pictures.some(({ sides }) => sides) || document.body.classList.contains('crowd')")
    yield page
    context.close()


def loading(browser: Browser, url: str, findings: Findings) -> None:
    """Measures the size of the page, and how soon it shows something that moves."""
    times = []
    for _ in range(NAVIGATIONS):
        with opened(browser, url, "") as page:
            until(page, "window.pictures.some(({ sides, time }) => sides && time > 0)")
            times.append(until(page, "window.pictures.find(({ sides, time }) => sides && time > 0).ended"))
            size = until(page, SENT)
    findings.add("page, kB", size / 1000.0, "{:.0f}", most=250.0)
    both(findings, "first picture, ms", times, "{:.0f}", most=5000.0)


def clicks(browser: Browser, url: str, findings: Findings) -> None:
    """Clicks on clips that were not shown before, and on the timeline, while the page plays."""
    times: dict[float, list[float]] = {0.0: [], 100.0: []}
    with opened(browser, url, "") as page:
        lists = [page.get_by_role("listbox").nth(n).locator("[role=option][aria-selected=false]") for n in range(2)]
        for click, pause in [(click, pause) for pause in times for click in range(CLICKS)]:
            others = lists[click % 2]
            option = others.nth((3 * click + bool(pause)) % others.count())
            page.wait_for_timeout(600.0)
            page.evaluate("window.page.sides.reload(window.page.sides.catalogue)")  # forget what was fetched
            page.evaluate("window.before = window.pictures.at(-1).sides")
            option.hover()
            page.wait_for_timeout(pause)
            option.click()
            times[pause].append(until(page, f"{NEXT} && sides !== window.before)?.ended - window.clicked"))
        for pause, found in times.items():
            label = f"click on {CLICKS} clips, " + (f"pointed at for {pause:.0f} ms" if pause else "at once")
            both(findings, f"{label}, ms", found, "{:.0f}", most=100.0)
        box = page.locator("#timeline canvas").first.bounding_box()
        assert box is not None
        seeks = []
        for click in range(CLICKS):
            page.wait_for_timeout(100.0)
            x = box["x"] + box["width"] * (0.3 + 0.6 * ((7 * click) % CLICKS) / CLICKS)
            page.mouse.click(x, box["y"] + 0.5 * box["height"])
            seeks.append(until(page, f"{NEXT})?.ended - window.clicked"))
        both(findings, "seek, ms", seeks, "{:.0f}", most=50.0)


def script(browser: Browser, url: str, seconds: float, findings: Findings) -> None:
    """Measures the script of a picture."""
    queries = {"splice beside naive": "action=wave", **{f"crowd of {n:,}": f"crowd={n}" for n in CROWDS}}
    for label, query in queries.items():
        with opened(browser, url, query) as page:
            if "crowd" in query:
                count = query.rpartition("=")[2]
                until(page, f"window.page?.viewer.crowd?.shown === {count}")
            page.wait_for_timeout(SETTLING)
            profiler = page.context.new_cdp_session(page)
            profiler.send("Performance.enable")
            page.evaluate("window.pictures.length = 0")
            before = _script_seconds(profiler)
            page.wait_for_timeout(1000.0 * seconds)
            spent = _script_seconds(profiler) - before
            taken: Any = page.evaluate("window.pictures.map(({ began, ended }) => ended - began)")
            both(findings, f"script, {label}, ms", taken, "{:.2f}", most=2.0 if query != "crowd=1000" else None)
            findings.add(f"all script, {label}, ms", 1000.0 * spent / len(taken))


def _script_seconds(profiler: Any) -> float:
    metrics = profiler.send("Performance.getMetrics")["metrics"]
    return float(next(one["value"] for one in metrics if one["name"] == "ScriptDuration"))


def both(findings: Findings, label: str, values: list[float], form: str, most: float | None) -> None:
    """Adds the median, which has a target, and the worst."""
    findings.add(f"{label}: median", float(np.median(values)), form, most=most)
    findings.add(f"{label}: worst", float(np.max(values)), form)


def main(
    bank: Annotated[Path | None, typer.Argument(help="Bank to serve.")] = None,
    seconds: Annotated[float, typer.Option(help="How long the script of each crowd is measured.")] = 5.0,
    check: Annotated[bool, typer.Option("--check", help="Exit with status 1 if a target is missed.")] = False,
) -> None:
    """Prints how fast the page is."""
    if CHROMIUM is None:
        raise SystemExit(MISSING)
    findings = Findings("The viewer's page, drawing left out")
    with (
        tempfile.TemporaryDirectory() as folder,
        serving(bank or built_in(Path(folder))) as service,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        loading(browser, service.url, findings)
        clicks(browser, service.url, findings)
        script(browser, service.url, seconds, findings)
        browser.close()
    findings.show()
    for sentence in findings.missed:
        print(sentence)
    if check and findings.missed:
        raise typer.Exit(1)


if __name__ == "__main__":
    run(lambda: typer.run(main))
