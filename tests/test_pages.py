"""Every command and every program of README and docs runs as it stands, in the order of its page.

A page runs in a folder in which `make demo` has left `demo/`. A block that needs what is not there says so in a comment
before it: `<!-- not run: needs your own clips -->`.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from motionsplice.motion.formats.reading import read_clip

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"(?:<!-- not run: (?P<reason>[^\n]+) -->\n)?^```(?P<language>\w*)\n(?P<code>.*?)^```", re.S | re.M)
PAGES = ["README.md", *(f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md")))]
LINKED = [  # every page of the project
    page.relative_to(ROOT).as_posix()
    for pattern in ("*.md", "docs/**/*.md", "clients/*.md", "clients/*/*.md", "deploy/*.md", "examples/*.md")
    for page in sorted(ROOT.glob(pattern))
]
ELSEWHERE = {"docs/protocol.md": "tests/service/test_protocol_page.py runs it against a service"}
WRITTEN = {"README.md": {"box.bvh": 361}, "docs/hands.md": {"directions+hands.bvh": 541}}  # motions, and their frames


class Block(NamedTuple):
    language: str
    code: str
    reason: str | None  # why it is not run


def blocks(page: str) -> Iterator[Block]:
    for found in BLOCK.finditer((ROOT / page).read_text(encoding="utf-8")):
        yield Block(found["language"], found["code"], found["reason"])


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder `demo` of `make demo`."""
    folder = tmp_path_factory.mktemp("demo") / "demo"
    command = [sys.executable, "-m", "motionsplice", "demo", str(folder)]
    subprocess.run(command, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, check=True)
    return folder


@pytest.mark.parametrize("page", [page for page in PAGES if page not in ELSEWHERE])
def test_what_a_page_says_runs(page: str, demo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(demo, tmp_path / "demo")
    names: dict[str, object] = {}
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for block in blocks(page):
        if block.reason is None and block.language == "python":
            exec(block.code, names)
        elif block.reason is None and block.language == "sh":
            done = subprocess.run(
                ["bash", "-eu", "-c", block.code],
                env={**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                check=False,
            )
            assert done.returncode == 0, f"{block.code}\n{done.stdout}\n{done.stderr}"
    found = {name: read_clip(Path(name)).clip.frame_count for name in WRITTEN.get(page, ())}
    assert found == WRITTEN.get(page, {})


@pytest.mark.parametrize("page", PAGES)
def test_a_block_says_its_language(page: str) -> None:
    assert {block.language for block in blocks(page)} <= {"sh", "python", "json", "toml", "text", "cpp", "js"}


@pytest.mark.parametrize("page", LINKED)
def test_links_lead_somewhere(page: str) -> None:
    targets = re.findall(r"\]\((?!https?:)([^)#]+)", (ROOT / page).read_text(encoding="utf-8"))
    missing = [target for target in targets if not exists((ROOT / page).parent / target)]
    assert not missing


def exists(file: Path) -> bool:
    """Whether a file is there; a source distribution has the folders of the packages in `motionsplice` only."""
    inside = file.resolve().relative_to(ROOT)
    return file.exists() or (ROOT / "motionsplice" / inside).exists()
