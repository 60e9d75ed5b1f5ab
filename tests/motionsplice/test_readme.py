from __future__ import annotations

import re
from pathlib import Path

import pytest

from motionsplice.motion.formats.files import read_clip
from motionsplice.motion.samples import write_sample_clips, write_sample_gestures

ROOT = Path(__file__).parents[2]


def test_the_python_in_the_readme_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    write_sample_clips(Path("demo/clips"))
    exec(code, {})
    assert read_clip(Path("box.bvh")).clip.frame_count == 361


def test_the_python_of_hands_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _ = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "hands.md").read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    write_sample_gestures(Path("demo/gestures"))
    exec(code, {})
    assert 320.0 <= float(capsys.readouterr().out.split()[0]) <= 330.0
    assert read_clip(Path("directions+hands.bvh")).clip.skeleton.joint_count == 52


@pytest.mark.parametrize("page", ["README.md", *(f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md")))])
def test_links_lead_somewhere(page: str) -> None:
    targets = re.findall(r"\]\(([^)#]+)", (ROOT / page).read_text())
    missing = [target for target in targets if not ((ROOT / page).parent / target).exists()]
    assert not missing
