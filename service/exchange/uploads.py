"""Taking in an uploaded clip: checked, and then put into the folder of clips whole or not at all."""

from __future__ import annotations

import asyncio
import fcntl
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import orjson

from motionsplice.motion.clip_settings import FILE_NAME, ClipSettings
from motionsplice.motion.errors import ClipError, did_you_mean
from motionsplice.motion.formats.files import clip_files
from motionsplice.service.exchange.spoken import Said, settings_of, written_beside
from motionsplice.service.problems import RequestError

LOCK, ROOM, SKELETON = ".clips.lock", ".upload-", ".asf"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_+-]{0,99}\.(bvh|amc|asf)")
PIECE = 2**20  # bytes that are written at once
CHECK_SECONDS = 120.0  # that reading a clip may take: a gigabyte of text takes a minute
ABANDONED = 3600.0  # seconds after which nobody is still sending a file


def checked_name(name: str) -> str:
    """A file's name that is one, and no path. Raises RequestError."""
    if not NAME.fullmatch(name):
        mend = "Letters, digits, _, + and -, and one of .bvh, .amc and .asf"
        raise RequestError(f"name: {name[:40]!r} is no name of a clip's file", mend=mend)
    return name


@dataclass(frozen=True)
class Uploads:
    """Takes clips into a folder, for a bank. One is checked at a time, for that may take a core and much memory."""

    folder: Path
    bank: Path
    checking: asyncio.Lock = field(default_factory=asyncio.Lock)

    async def take(self, name: str, said: Said, body: AsyncIterator[bytes]) -> None:
        """Puts a file into the folder of clips, in place of one of the same name.

        Raises RequestError, SettingsError, ClipError if it is no motion that fits the bank, or whatever `body` raises;
        nothing is left behind or changed then.
        """
        own = Path(checked_name(name))
        await asyncio.to_thread(self._agree, own, said)
        await asyncio.to_thread(self._clear)
        room = Path(tempfile.mkdtemp(prefix=ROOM, dir=self.folder))
        try:
            file = room / name
            await _write(file, body)
            settings = await asyncio.to_thread(settings_of, self.folder / FILE_NAME, own.stem)
            for skeleton in self.folder.glob(f"*{SKELETON}") if own.suffix == ".amc" else ():
                os.link(skeleton, room / skeleton.name)  # without which it cannot be read
            async with self.checking:
                await _check(file, self.bank, settings)
            await asyncio.to_thread(self._put, file, said)
        finally:
            shutil.rmtree(room, ignore_errors=True)  # at once, for a cancelled task would wait for no thread

    def _clear(self) -> None:
        """Removes what a service that was killed left of uploads."""
        for room in self.folder.glob(f"{ROOM}*"):
            if time.time() - room.stat().st_mtime > ABANDONED:
                shutil.rmtree(room, ignore_errors=True)

    def _agree(self, own: Path, said: Said) -> None:
        """That a file may be put into the folder, as it is now. Raises RequestError."""
        if own.suffix == SKELETON:
            if said != Said():
                raise RequestError("kind, neutral and tags are a clip's", mend="Say them with its .amc")
            return
        clips = clip_files(self.folder)
        for other in clips:
            if other.stem == own.stem and other.name != own.name:
                raise RequestError(f"name: there is a clip {other.name} already", mend="Give it another name")
        names = {one.stem for one in clips} | {own.stem}
        if said.neutral is not None and said.neutral not in names:
            mend = did_you_mean(said.neutral, names)
            raise RequestError(f"neutral: there is no clip {said.neutral[:40]!r} in the folder", mend=mend)

    def _put(self, file: Path, said: Said) -> None:
        with locked(self.folder / LOCK):
            self._agree(Path(file.name), said)
            spoken = self.folder / FILE_NAME
            fresh = written_beside(spoken, file.stem, said) if said != Said() else None
            os.replace(file, self.folder / file.name)  # first the clip: an entry without one would fail the whole job
            if fresh is not None:
                os.replace(fresh, spoken)
            descriptor = os.open(self.folder, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)


async def _write(file: Path, body: AsyncIterator[bytes]) -> None:
    """A body as a file, synced, by a thread, since a disk may be slow."""
    with file.open("wb", buffering=0) as sink:
        held = bytearray()
        async for chunk in body:
            held += chunk
            if len(held) >= PIECE:
                await asyncio.to_thread(sink.write, bytes(held))
                held.clear()
        await asyncio.to_thread(sink.write, bytes(held))
        await asyncio.to_thread(os.fsync, sink.fileno())


async def _check(file: Path, bank: Path, settings: ClipSettings) -> None:
    """Reads a clip in a process of its own, which may take long or fail without harm. Raises ClipError."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "motionsplice.precompute.job.check", str(file), str(bank)),
        *(str(settings.skip_frames), settings.unit or ""),
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
        problem = orjson.loads(told)
    except orjson.JSONDecodeError:
        raise ClipError("reading it failed", file=file.name, mend="It may be too large") from None
    if problem:
        raise ClipError(problem["problem"], file=file.name, place=problem["place"], mend=problem["mend"])


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Holds a lock among all processes; it is let go even by one that is killed."""
    with file.open("ab") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
