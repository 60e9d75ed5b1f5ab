"""Taking in an uploaded clip: checked, and then put into the folder of clips whole or not at all."""

from __future__ import annotations

import asyncio
import fcntl
import os
import re
import shutil
import sys
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import orjson
import tomlkit

from motion.errors import ClipError, SettingsError
from service.problems import RequestError

SETTINGS_FILE, LOCK = "clips.toml", ".clips.lock"
MOTIONS, SKELETON = (".bvh", ".amc"), ".asf"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_+-]{0,99}\.(bvh|amc|asf)")
CHECK_SECONDS = 120.0  # that reading a clip may take: a gigabyte of text takes a minute


@dataclass(frozen=True)
class Said:
    """What `clips.toml` is to say of a clip; None leaves what it says."""

    kind: str | None
    neutral: str | None
    tags: tuple[str, ...] | None


def checked_name(name: str) -> str:
    """A file's name that is one, and no path. Raises RequestError."""
    if not NAME.fullmatch(name):
        mend = "Letters, digits, _, + and -, and one of .bvh, .amc and .asf"
        raise RequestError(f"name: {name[:40]!r} is no name of a clip's file", mend=mend)
    return name


async def take_in(folder: Path, name: str, said: Said, body: AsyncIterator[bytes]) -> None:
    """Puts a file into the folder of clips, in place of one of the same name.

    Raises RequestError, MotionError if it is no motion, or whatever `body` raises; nothing is left behind then.
    """
    own, stem = Path(checked_name(name)), Path(name).stem
    for suffix in MOTIONS:
        if own.suffix in MOTIONS and suffix != own.suffix and (folder / f"{stem}{suffix}").exists():
            raise RequestError(f"name: there is a clip {stem}{suffix} already", mend="Give it another name")
    room = Path(await asyncio.to_thread(tempfile.mkdtemp, prefix=".upload-", dir=folder))
    try:
        file = room / name
        with file.open("wb") as data:
            async for chunk in body:
                data.write(chunk)
            await asyncio.to_thread(os.fsync, data.fileno())
        if own.suffix == ".amc":  # which cannot be read without its skeleton
            for skeleton in folder.glob(f"*{SKELETON}"):
                os.link(skeleton, room / skeleton.name)
        if own.suffix in MOTIONS:
            await _check(file)
        await asyncio.to_thread(_put, folder, file, said)
    finally:
        await asyncio.to_thread(shutil.rmtree, room, ignore_errors=True)


async def _check(file: Path) -> None:
    """Reads a clip in a process of its own, which may take long or fail without harm. Raises ClipError."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "service.exchange.check", str(file)),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
    )
    try:
        async with asyncio.timeout(CHECK_SECONDS):
            told, _ = await process.communicate()
    except TimeoutError:
        raise ClipError(f"reading it took more than {CHECK_SECONDS:g} s", file=file.name) from None
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    try:
        problem = orjson.loads(told)["problem"]
    except (orjson.JSONDecodeError, KeyError):
        raise ClipError("reading it failed", file=file.name, mend="It may be too large") from None
    if problem:
        raise ClipError(problem.rstrip("."), file=file.name)


def _put(folder: Path, file: Path, said: Said) -> None:
    with locked(folder / LOCK):
        os.replace(file, folder / file.name)
        if said != Said(None, None, None):
            _write_down(folder / SETTINGS_FILE, file.stem, said)
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _write_down(file: Path, clip: str, said: Said) -> None:
    """Says it in `clips.toml`, and keeps all else that is there. Raises SettingsError if that is no TOML."""
    try:
        document = tomlkit.parse(file.read_text(encoding="utf-8")) if file.exists() else tomlkit.document()
    except (tomlkit.exceptions.ParseError, UnicodeDecodeError) as error:
        raise SettingsError(f"it is not TOML: {error}", file=file.name, mend="Mend it by hand") from None
    entry = document.setdefault(clip, tomlkit.table())
    for key, value in (("kind", said.kind), ("neutral", said.neutral), ("tags", said.tags)):
        if value is not None:
            entry[key] = list(value) if isinstance(value, tuple) else value
    fresh = file.with_name(f".{file.name}.new")
    fresh.write_text(tomlkit.dumps(document), encoding="utf-8")
    os.replace(fresh, file)


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Holds a lock among all processes; it is let go even by one that is killed."""
    with file.open("ab") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
