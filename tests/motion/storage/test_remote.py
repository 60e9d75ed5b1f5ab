"""Files at URLs, in fsspec's file system in memory."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motionsplice.motion.errors import FormatError, SettingsError
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.files import clip_files, files_behind, read_bytes
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.procedural.library import make
from motionsplice.motion.storage.place import among, place_of, read_ahead
from motionsplice.motion.storage.remote import Remote, StorageError
from tests.s3 import bucket

fsspec = pytest.importorskip("fsspec", reason="the extra motionsplice[cluster] is not installed")


@pytest.fixture
def memory() -> Iterator[Any]:
    system = fsspec.filesystem("memory")
    names = ("walk.bvh", "16.asf", "16_15.amc", "more/a.bvh")
    system.pipe({f"/clips/{name}": name.encode() for name in names})
    yield system
    system.rm("/", recursive=True)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("clips/walk.bvh", Path("clips/walk.bvh")),
        ("C:/clips", Path("C:/clips")),
        ("file:///srv/my%20clips", Path("/srv/my clips")),
        (Path("clips"), Path("clips")),
        ("s3://bucket/clips/", Remote("s3://bucket/clips")),
        (Remote("gs://bucket/a"), Remote("gs://bucket/a")),
    ],
)
def test_a_path_is_a_path_and_a_url_a_url(text: str, place: object) -> None:
    assert place_of(text) == place


def test_an_empty_path_is_refused_instead_of_being_the_current_folder() -> None:
    with pytest.raises(SettingsError, match="the path is empty"):
        place_of("")


def test_a_folder_is_listed_once_by_all_that_were_found_in_it(memory: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    lists = list[str]()
    ls = type(memory).ls

    def noting(self: Any, path: str, **how: Any) -> Any:
        lists.append(path)
        return ls(self, path, **how)

    monkeypatch.setattr(type(memory), "ls", noting)
    folder = Remote("memory://clips")
    assert [file.name for file in clip_files(folder)] == ["16_15.amc", "walk.bvh"]
    assert (folder / "walk.bvh").is_file()
    assert not (folder / "clips.toml").is_file()
    assert (folder / "more").is_dir()
    first = clip_files(folder)[0]
    assert [file.name for file in files_behind(first)] == ["16_15.amc", "16.asf"]
    assert first.exists()
    assert not first.is_dir()
    assert not (folder / "clips.toml").exists()
    read_bytes(first)
    taken = pickle.loads(pickle.dumps(among(first, files_behind(first))))
    assert taken == first
    assert [file.name for file in files_behind(taken)] == ["16_15.amc", "16.asf"]
    assert not taken.is_dir()
    assert not (taken.parent / "walk.bvh").exists()  # it knows of no others
    assert lists == ["/clips"]
    assert pickle.loads(pickle.dumps(first)).parent.is_dir()
    assert lists.count("/clips") == 2


def test_names_are_those_of_paths(memory: Any) -> None:
    file = Remote("memory://clips/more/a.b.bvh")
    path = Path("/clips/more/a.b.bvh")
    for part in ("name", "stem", "suffix"):
        assert getattr(file, part) == getattr(path, part)
    assert file.parent.name == path.parent.name
    outside = file.parent / "../../other/b.bin"
    assert outside.resolve() == Remote("memory://other/b.bin")
    assert not outside.resolve().is_relative_to(file.parent)
    assert (file.parent / "x/b.bin").resolve().is_relative_to(file.parent)
    assert not Remote("memory://clips/more2").is_relative_to(Remote("memory://clips/more"))


def test_a_clip_is_read_from_a_url(memory: Any) -> None:
    walk = make("walk", seconds=2.0)
    memory.pipe("/clips/walk.bvh", dump_bvh(walk))
    assert read_clip("memory://clips/walk.bvh", unit="m").clip.frame_count == walk.frame_count
    with pytest.raises(FormatError, match=r"memory://clips/absent\.bvh: no such file"):
        read_clip("memory://clips/absent.bvh")


def test_files_are_read_ahead_in_order(memory: Any) -> None:
    memory.pipe({f"/many/{number:03}": str(number).encode() for number in range(300)})
    files = sorted(Remote("memory://many").iterdir())
    assert read_ahead(Remote.read_bytes, files, lambda file: file) == [str(number).encode() for number in range(300)]


def test_a_mark_changes_when_a_file_is_written_anew(memory: Any) -> None:
    file = Remote("memory://clips/walk.bvh")
    before = file.mark()
    assert before == file.mark()
    file.write_bytes(b"another walk")
    assert before != file.mark()
    file.parent.remove(["walk.bvh"])
    assert file.mark() is None


def test_a_protocol_that_nobody_knows_is_named() -> None:
    with pytest.raises(StorageError, match=r"^pigeon://loft/clips: pigeon:// cannot be used: Protocol not known"):
        Remote("pigeon://loft/clips").exists()


def test_an_extra_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def without_s3fs(url: str) -> Any:
        raise ImportError("Install s3fs to access S3")

    monkeypatch.setattr("fsspec.core.url_to_fs", without_s3fs)
    with pytest.raises(StorageError, match=r"Install s3fs to access S3\. Run `pip install 'motionsplice\[s3\]'`"):
        Remote("s3://bucket/clips").exists()


def test_an_object_is_read_by_one_request_whether_it_is_there_or_not(monkeypatch: pytest.MonkeyPatch) -> None:
    with bucket(monkeypatch) as url:
        (Remote(url) / "walk.bvh").write_bytes(b"walk")
        (Remote(url) / "empty.toml").write_bytes(b"")
        s3fs, asked = pytest.importorskip("s3fs"), list[str]()
        call = s3fs.S3FileSystem._call_s3

        async def noting(self: Any, method: str, *given: Any, **how: Any) -> Any:
            asked.append(method)
            return await call(self, method, *given, **how)

        monkeypatch.setattr(s3fs.S3FileSystem, "_call_s3", noting)
        assert (Remote(url) / "walk.bvh").read_bytes() == b"walk"
        assert (Remote(url) / "empty.toml").read_bytes() == b""
        with pytest.raises(FileNotFoundError):
            (Remote(url) / "run.bvh").read_bytes()
        assert asked == ["get_object"] * 3
