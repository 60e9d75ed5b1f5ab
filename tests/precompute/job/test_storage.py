"""The job with clips, cache and bank at URLs."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionsplice.motion.clip_settings import ClipSettings
from motionsplice.motion.errors import BankError, SkeletonError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.files import clip_files
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.storage.remote import Remote, StorageError
from motionsplice.precompute.job import job
from motionsplice.precompute.job.cache import CacheError
from motionsplice.precompute.job.clip_work import Preparation
from motionsplice.precompute.job.install import install_bank, publish_bank
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.readings import Identified, contents_of, identify, read
from motionsplice.precompute.job.remote_cache import RemoteCache
from motionsplice.precompute.job.sources import Source
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST
from tests.conftest import CLIPS
from tests.precompute.job.test_job import files_of, write

fsspec = pytest.importorskip("fsspec", reason="the extra motionsplice[cluster] is not installed")

NAMES = ("carry_box", "run", "walk")
TOML = "[carry_box]\nkind = 'action'\nneutral = 'walk'\n"
BANK = Remote("memory://bank")


def quiet(stage: str, done: int, total: int) -> None:
    pass


@pytest.fixture
def memory() -> Iterator[Any]:
    system = fsspec.filesystem("memory")
    system.pipe({f"/clips/{name}.bvh": dump_bvh(CLIPS[name]) for name in NAMES})
    system.pipe("/clips/clips.toml", TOML.encode())
    yield system
    system.rm("/", recursive=True)


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of the bank that the job makes of the same clips in a folder."""
    folder = tmp_path_factory.mktemp("expected")
    clips = write(folder / "clips", **{name: CLIPS[name] for name in NAMES})
    (clips / "clips.toml").write_text(TOML)
    build_bank([clips], folder / "bank")
    return files_of(folder / "bank")


def at(system: Any, root: str) -> dict[str, bytes]:
    """Returns the files of the bank at a URL."""
    found = system.cat(system.find(root))
    return {name.partition("bank/")[2]: data for name, data in found.items() if "/cache/" not in name}


def test_a_bank_at_a_url_has_the_same_bytes_and_a_second_run_does_nothing(
    memory: Any, expected: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[str] = []
    pipe_file = type(memory).pipe_file

    def noting(self: Any, path: str, *given: Any, **how: Any) -> None:
        written.append(path)
        pipe_file(self, path, *given, **how)

    monkeypatch.setattr(type(memory), "pipe_file", noting)
    assert not build_bank("memory://clips", "memory://bank").unchanged
    assert at(memory, "/bank") == expected
    assert [name for name in written if "/cache/" not in name] == [f"/bank/{MANIFEST}"]  # tables are uploaded before
    before = memory.find("/bank")
    monkeypatch.setattr(job, "write_bank", None)
    second = build_bank("memory://clips", "memory://bank")
    assert (second.unchanged, second.reused) == (True, len(NAMES))
    assert memory.find("/bank") == before


def test_workers_without_copies_make_the_same_bank_and_others_entries_are_removed(
    memory: Any, expected: dict[str, bytes]
) -> None:
    old, mine = f"/bank/cache/{'0' * 32}.entry", "/bank/cache/mine.txt"
    memory.pipe({old: b"of another day", mine: b"mine"})
    with ThreadPoolExecutor(2) as pool:
        build_bank("memory://clips", "memory://bank", executor=pool)
    assert at(memory, "/bank") == expected
    assert (memory.exists(old), memory.exists(mine)) == (False, True)


def test_a_changed_clip_is_the_only_one_aligned_again(memory: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    build_bank("memory://clips", "memory://bank", baseline="walk")
    tables = set(memory.ls("/bank/tables", detail=False))
    run, aligned = Preparation.run, []

    def noting(self: Preparation, one: Identified) -> None:
        aligned.append(one.source.name)
        run(self, one)

    monkeypatch.setattr(Preparation, "run", noting)
    counts = []
    for frames in (150, 151, 152):
        memory.pipe("/clips/run.bvh", dump_bvh(CLIPS["run"].frames(0, frames)))
        build_bank("memory://clips", "memory://bank", baseline="walk")
        counts.append(len(memory.ls("/bank/tables")))
    assert aligned == ["run"] * 3
    assert counts[2] == counts[1]  # the tables of the bank before, and none that are older
    assert not tables <= set(memory.ls("/bank/tables", detail=False))


def test_damaged_entries_at_a_url_are_made_again(memory: Any, expected: dict[str, bytes]) -> None:
    build_bank("memory://clips", "memory://bank")
    memory.pipe(dict.fromkeys(memory.find("/bank/cache"), b"damaged"))
    memory.rm(f"/bank/{MANIFEST}")
    build_bank("memory://clips", "memory://bank")
    assert at(memory, "/bank") == expected


def test_a_cache_that_cannot_be_written_ends_the_job(memory: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError("Access Denied")

    monkeypatch.setattr(type(memory), "pipe_file", refuse)
    with pytest.raises(CacheError, match=r"memory://bank/cache: cannot write to the cache: .*Access Denied"):
        build_bank("memory://clips", "memory://bank")


def test_storage_that_refuses_a_clip_ends_the_job_and_the_bank_stays(
    memory: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    build_bank("memory://clips", "memory://bank")
    before, cat_file = at(memory, "/bank"), type(memory).cat_file

    def refuse(self: Any, path: str, *given: Any, **how: Any) -> Any:
        if path.endswith("run.bvh"):
            raise PermissionError("Access Denied")
        return cat_file(self, path, *given, **how)

    monkeypatch.setattr(type(memory), "cat_file", refuse)
    with pytest.raises(StorageError, match=r"memory://clips/run\.bvh: the storage cannot be used: .*Access Denied"):
        build_bank("memory://clips", "memory://bank")
    monkeypatch.undo()
    assert at(memory, "/bank") == before


def test_a_bank_is_copied_to_a_url_and_back(memory: Any, bank: Bank, tmp_path: Path) -> None:
    assert install_bank(bank.path, BANK, quiet) == bank.digest
    assert at(memory, "/bank") == files_of(bank.path)
    assert install_bank(BANK, tmp_path / "copy", quiet) == bank.digest
    assert files_of(tmp_path / "copy") == files_of(bank.path)
    assert install_bank(BANK, Remote("memory://other/bank"), quiet) == bank.digest
    assert at(memory, "/other/bank") == files_of(bank.path)


def test_only_tables_that_are_missing_or_cut_short_are_copied(memory: Any, bank: Bank, tmp_path: Path) -> None:
    publish_bank(bank.path, BANK, quiet)
    first, second, *_ = memory.ls("/bank/tables", detail=False)
    memory.rm(first)
    memory.pipe(second, memory.cat(second)[:-1])
    steps: list[tuple[str, int, int]] = []
    publish_bank(bank.path, BANK, lambda *step: steps.append(step))
    assert steps == [("copying", 1, 2), ("copying", 2, 2)]
    assert at(memory, "/bank") == files_of(bank.path)


def test_a_damaged_or_missing_bank_at_a_url_is_not_copied(memory: Any, bank: Bank, tmp_path: Path) -> None:
    with pytest.raises(BankError, match=r"memory://bank: there is no bank. Build one"):
        install_bank(BANK, tmp_path / "copy", quiet)
    publish_bank(bank.path, BANK, quiet)
    install_bank(BANK, tmp_path / "copy", quiet)
    largest = max(memory.ls("/bank/tables"), key=lambda one: one["size"])["name"]
    name = largest.rpartition("/")[2]
    (tmp_path / "copy" / "tables" / name).unlink()
    memory.pipe(largest, memory.cat(largest)[:-1] + b"\x00")
    with pytest.raises(BankError, match=r"memory://bank: the bank changed while it was copied. Try again"):
        install_bank(BANK, tmp_path / "copy", quiet)
    memory.rm(largest)
    with pytest.raises(BankError, match=r"memory://bank: the bank changed"):
        install_bank(BANK, tmp_path / "copy", quiet)


def test_a_skeleton_is_read_from_a_file_at_a_url_but_not_from_a_bank_there(memory: Any, tmp_path: Path) -> None:
    build_bank("memory://clips", tmp_path / "bank", baseline="run", skeleton="memory://clips/walk.bvh")
    expected = read_clip("memory://clips/walk.bvh").clip.skeleton
    np.testing.assert_array_equal(Bank.open(tmp_path / "bank").skeleton.offsets, expected.offsets)
    with pytest.raises(SkeletonError, match=r"memory://clips: the skeleton of a bank at a URL cannot be read\. Copy"):
        build_bank("memory://clips", tmp_path / "other", baseline="run", skeleton="memory://clips")


def test_a_worker_reads_and_writes_entries_without_copies(memory: Any, tmp_path: Path) -> None:
    cache = RemoteCache(BANK / "cache", tmp_path)
    ours, theirs = "0" * 32, "1" * 32
    cache.store(ours, {"number": 1}, {"rows": np.arange(3)})
    worker = pickle.loads(pickle.dumps(cache))
    assert worker.load(ours, lambda fields, arrays: (fields["number"], arrays["rows"].tolist())) == (1, [0, 1, 2])
    worker.store(theirs, {"number": 2}, {})
    assert [file.name for file in tmp_path.iterdir()] == [f"{ours}.entry"]
    cache.read_ahead([ours, theirs, "2" * 32])
    memory.rm("/bank", recursive=True)
    assert cache.load(theirs, lambda fields, _: fields["number"]) == 2
    assert cache.load("2" * 32, lambda fields, _: fields) is None


def test_a_worker_asks_for_the_file_of_its_clip_once_and_for_nothing_else(
    memory: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    [file] = [file for file in clip_files(Remote("memory://clips")) if file.stem == "walk"]
    one = pickle.loads(pickle.dumps(identify(Source("walk", file, None, ClipSettings()), contents_of(file))))
    asked = list[str]()
    for name in ("ls", "info", "cat_file"):
        real = getattr(type(memory), name)

        def noting(self: Any, path: str, *given: Any, name: str = name, real: Any = real, **how: Any) -> Any:
            asked.append(f"{name} {path}")
            return real(self, path, *given, **how)

        monkeypatch.setattr(type(memory), name, noting)
    assert read(one).clip.frame_count == CLIPS["walk"].frame_count
    assert asked == ["cat_file /clips/walk.bvh"]
