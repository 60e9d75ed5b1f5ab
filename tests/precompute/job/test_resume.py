"""The offline job does not repeat work whose results it has."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from motionsplice.motion.clip_settings import ClipSettings
from motionsplice.motion.errors import ClipError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.files import Read
from motionsplice.motion.formats.reading import Reading, read_as
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job import job, readings
from motionsplice.precompute.job.alone import LOCK
from motionsplice.precompute.job.clip_work import Preparation
from motionsplice.precompute.job.destination import CACHE
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.outcome import Outcome
from motionsplice.precompute.job.readings import Identified
from motionsplice.runtime.bank import Bank
from tests.conftest import CLIPS
from tests.precompute.job.test_job import files_of

CLIPS_TOML = "[carry_box]\nkind = 'action'\nneutral = 'walk'\n"
NAMES = ("carry_box", "run", "side_step", "walk")


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    folder = tmp_path / "clips"
    folder.mkdir()
    for name in NAMES:
        (folder / f"{name}.bvh").write_bytes(dump_bvh(CLIPS[name]))
    (folder / "clips.toml").write_text(CLIPS_TOML)
    return folder


@pytest.fixture
def aligned(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Collects the names of the clips that are aligned."""
    names: list[str] = []
    run = Preparation.run

    def noting(self: Preparation, one: Identified) -> None:
        names.append(one.source.name)
        run(self, one)

    monkeypatch.setattr(Preparation, "run", noting)
    return names


def build(clips: Path, baseline: str | None = "walk") -> Outcome:
    return build_bank([clips], clips.parent / "bank", baseline=baseline)


def afresh(clips: Path, baseline: str | None = "walk") -> dict[str, bytes]:
    """Returns the files of the bank that a job without a cache makes."""
    out = clips.parent / "afresh"
    build_bank([clips], out, baseline=baseline)
    return files_of(out)


def tables_and_manifest(bank: Path) -> dict[str, bytes]:
    """Returns the current bank's files, without the previous bank's."""
    used = {f"{digest}.npy" for digest in Bank.open(bank).manifest.tables.values()}
    return {
        name: data for name, data in files_of(bank).items() if Path(name).suffix != ".npy" or Path(name).name in used
    }


@pytest.mark.parametrize("baseline", ["walk", None])
def test_a_second_run_does_nothing(
    clips: Path, aligned: list[str], baseline: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = build(clips, baseline)
    assert (first.reused, first.unchanged, sorted(aligned)) == (0, False, list(NAMES))
    bank = clips.parent / "bank"
    before = changed(bank)
    aligned.clear()
    monkeypatch.setattr(readings, "read_as", None)
    monkeypatch.setattr(job, "write_bank", None)
    steps: list[str] = []
    second = build_bank([clips], bank, baseline=baseline, progress=lambda stage, done, total: steps.append(stage))
    assert (second.reused, second.unchanged) == (len(NAMES), True)
    assert (second.digest, second.clips) == (first.digest, first.clips)
    assert not aligned + steps
    assert changed(bank) == before


def changed(bank: Path) -> dict[Path, int]:
    """Returns when each file of a bank was changed, but for the lock."""
    return {file: file.stat().st_mtime_ns for file in bank.rglob("*") if file.is_file() and file.name != LOCK}


def test_a_changed_clip_is_the_only_one_aligned_again(clips: Path, aligned: list[str]) -> None:
    build(clips)
    (clips / "run.bvh").write_bytes(dump_bvh(make("run", seed=9, seconds=3.0)))
    aligned.clear()
    outcome = build(clips)
    assert aligned == ["run"]
    assert (outcome.reused, outcome.unchanged) == (len(NAMES) - 1, False)
    assert tables_and_manifest(clips.parent / "bank") == afresh(clips)


@pytest.mark.parametrize(
    ("settings", "costs"),
    [
        (CLIPS_TOML + "[run]\nskip_frames = 3\n", ["run"]),
        (CLIPS_TOML + "[run]\nunit = 'm'\n", ["run"]),
        (CLIPS_TOML + "[run]\nup = 'y'\n", ["run"]),
        (CLIPS_TOML + "[run]\nrate = 60\n", ["run"]),
        (CLIPS_TOML + "[run]\nroot = 'Hips'\n", ["run"]),
        (CLIPS_TOML + "tags = ['box']\n", []),
        ("[carry_box]\nkind = 'action'\nneutral = 'run'\n", []),
        ("", []),
    ],
)
def test_changed_settings_align_only_dependent_clips_again(
    clips: Path, aligned: list[str], settings: str, costs: list[str]
) -> None:
    build(clips)
    (clips / "clips.toml").write_text(settings)
    aligned.clear()
    assert not build(clips).unchanged
    assert aligned == costs
    assert tables_and_manifest(clips.parent / "bank") == afresh(clips)


def test_a_changed_baseline_aligns_all_clips_again(clips: Path, aligned: list[str]) -> None:
    build(clips)
    aligned.clear()
    build(clips, "run")
    assert sorted(aligned) == list(NAMES)
    (clips / "run.bvh").write_bytes(dump_bvh(make("run", seed=9, seconds=3.0)))
    aligned.clear()
    build(clips, "run")
    assert sorted(aligned) == list(NAMES)
    assert tables_and_manifest(clips.parent / "bank") == afresh(clips, "run")


def test_another_version_of_the_method_aligns_all_clips_again(
    clips: Path, aligned: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    build(clips)
    aligned.clear()
    monkeypatch.setattr(readings, "version_of_method", lambda: "another day's")
    build(clips)
    assert sorted(aligned) == list(NAMES)


def test_a_renamed_clip_is_not_aligned_again(clips: Path, aligned: list[str]) -> None:
    build(clips)
    aligned.clear()
    (clips / "run.bvh").rename(clips / "sprint.bvh")
    assert build(clips).clips == ("carry_box", "side_step", "sprint", "walk")
    assert not aligned
    assert tables_and_manifest(clips.parent / "bank") == afresh(clips)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 something else"])
def test_damaged_results_are_made_again(clips: Path, content: bytes) -> None:
    build(clips, None)
    bank = clips.parent / "bank"
    for file in (bank / CACHE).iterdir():
        file.write_bytes(content)
    assert not build(clips, None).unchanged
    assert tables_and_manifest(bank) == afresh(clips, None)


def test_a_damaged_or_missing_bank_is_written_again(clips: Path, aligned: list[str]) -> None:
    build(clips)
    bank = clips.parent / "bank"
    before = files_of(bank)
    table = next(file for file in (bank / "tables").iterdir())
    table.write_bytes(table.read_bytes()[:-1])
    aligned.clear()
    assert not build(clips).unchanged
    assert files_of(bank) == before
    (bank / "manifest.msgpack").unlink()
    assert not build(clips).unchanged
    assert files_of(bank) == before
    assert not aligned


def test_results_of_removed_clips_are_removed(clips: Path) -> None:
    build(clips)
    before = len(list((clips.parent / "bank" / CACHE).iterdir()))
    (clips / "run.bvh").unlink()
    build(clips)
    assert len(list((clips.parent / "bank" / CACHE).iterdir())) == before - 1


def test_a_failed_clip_is_tried_and_reported_again(clips: Path) -> None:
    (clips / "broken.bvh").write_bytes(b"HIERARCHY\nROOT")
    first, second = build(clips), build(clips)
    assert second.unchanged
    assert str(first.failed["broken"]) == str(second.failed["broken"])


def test_a_clip_that_changes_while_it_is_read_fails(clips: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def changing(asked: ClipSettings, path: Path, animation: str | None, read: Read) -> Reading:
        if path.stem == "run":
            path.write_bytes(path.read_bytes() + b"\n")
        return read_as(asked, path, animation, read)

    monkeypatch.setattr(readings, "read_as", changing)
    outcome = build(clips)
    assert isinstance(outcome.failed["run"], ClipError)
    assert "it changed while it was read. Start again" in str(outcome.failed["run"])
    monkeypatch.undo()
    assert build(clips).reused == len(NAMES) - 1


KILLED = """
import os, signal, sys
from pathlib import Path
from motionsplice.precompute.job.job import build_bank

def kill(stage, done, total):
    if (stage, done) == ("aligning", 2):
        os.kill(os.getpid(), signal.SIGKILL)

build_bank([Path(sys.argv[1])], Path(sys.argv[2]), baseline="walk", progress=kill)
"""


def test_a_killed_job_resumes_where_it_stopped(clips: Path, aligned: list[str]) -> None:
    bank = clips.parent / "bank"
    project = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    killed = subprocess.run([sys.executable, "-c", KILLED, str(clips), str(bank)], env=project, check=False)
    assert killed.returncode == -signal.SIGKILL
    assert not (bank / "manifest.msgpack").exists()
    outcome = build(clips)
    assert outcome.reused == 2
    assert sorted(aligned) == list(NAMES)[2:]
    assert files_of(bank) == afresh(clips)


def test_processes_and_the_order_of_the_files_make_no_difference(clips: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job, "WORTH_A_PROCESS", 1)
    build(clips, None)
    files = [clips / f"{name}.bvh" for name in reversed(NAMES)]
    build_bank(files, clips.parent / "other", jobs=2)
    assert files_of(clips.parent / "other") == files_of(clips.parent / "bank")
