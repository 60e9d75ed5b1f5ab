"""Receives uploaded clips: a clip is checked, then moved into the folder of clips as a whole."""

from __future__ import annotations

import asyncio
import fcntl
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import orjson

from motionsplice.motion.clip_settings import FILE_NAME, ClipSettings
from motionsplice.motion.errors import ClipError, did_you_mean
from motionsplice.motion.formats.files import SUFFIXES, clip_files
from motionsplice.service.exchange.clip_entries import EntryUpdate, settings_of, written_beside
from motionsplice.service.problems import RequestError, TooLargeError

LOCK, ROOM, SKELETON = ".clips.lock", ".upload-", ".asf"
KINDS = (*SUFFIXES, SKELETON)
NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9_+-]{{0,99}}({'|'.join(map(re.escape, KINDS))})")
PIECE = 2**20  # bytes written at once
CHECK_SECONDS = 120.0  # time for reading a clip; a gigabyte of text takes a minute
DELETE = "Ask whoever runs the service to delete clips there, or to raise its --max-clips or --max-stored"
ABANDONED = 3600.0  # seconds after which an unfinished upload is deleted


def checked_name(name: str) -> str:
    """Returns a file name if it is valid and has no folder. Raises RequestError."""
    if not NAME.fullmatch(name):
        mend = f"Use letters, digits, _, + and -, and end it in {', '.join(KINDS)}"
        raise RequestError(f"name: {name[:40]!r} is not a valid file name of a clip", mend=mend)
    return name


@dataclass(frozen=True)
class Quota:
    """The quota of a folder of clips: a number of files, and bytes in all, unfinished uploads included."""

    files: int
    bytes: int

    def check(self, folder: Path, name: str) -> None:
        """Checks what a folder holds without the clip `name`, which an upload of this name replaces.

        Raises TooLargeError.
        """
        others = [one for one in folder.rglob("*") if one.is_file() and one != folder / name]
        if sum(one.parent == folder and one.suffix in KINDS for one in others) >= self.files:
            raise TooLargeError(f"the folder of clips has {self.files} files already", mend=DELETE)
        if sum(one.stat().st_size for one in others) > self.bytes:
            raise TooLargeError(f"the folder of clips has more than {self.bytes} bytes", mend=DELETE)


@dataclass(frozen=True)
class Uploads:
    """Stores clips in a folder, for a bank. One is checked at a time, as that may take a core and much memory."""

    folder: Path
    bank: Path
    quota: Quota
    checking: asyncio.Lock = field(default_factory=asyncio.Lock)

    async def take(self, name: str, update: EntryUpdate, body: AsyncIterator[bytes]) -> None:
        """Stores a file in the folder of clips, and replaces one of the same name.

        Raises RequestError, SettingsError, ClipError if the file is not a motion that fits the bank, TooLargeError if
        the folder is full, or what `body` raises. The folder is unchanged then.
        """
        own = Path(checked_name(name))
        await asyncio.to_thread(self._check_request, own, update)
        await asyncio.to_thread(self._clear)
        check_quota = partial(self.quota.check, self.folder, name)
        await asyncio.to_thread(check_quota)
        room = Path(tempfile.mkdtemp(prefix=ROOM, dir=self.folder))
        try:
            file = room / name
            await _write(file, body, check_quota)
            settings = await asyncio.to_thread(settings_of, self.folder / FILE_NAME, own.stem)
            for skeleton in self.folder.glob(f"*{SKELETON}") if own.suffix == ".amc" else ():
                os.link(skeleton, room / skeleton.name)  # an .amc is read with its .asf
            async with self.checking:
                await _check(file, self.bank, settings)
            await asyncio.to_thread(self._put, file, update)
        finally:
            shutil.rmtree(room, ignore_errors=True)  # not in a thread, which a cancelled task would not wait for

    def _clear(self) -> None:
        """Deletes uploads that a killed service left unfinished."""
        for room in self.folder.glob(f"{ROOM}*"):
            if time.time() - room.stat().st_mtime > ABANDONED:
                shutil.rmtree(room, ignore_errors=True)

    def _check_request(self, own: Path, update: EntryUpdate) -> None:
        """Checks that a file may be stored in the folder as it is now. Raises RequestError."""
        if own.suffix == SKELETON:
            if update != EntryUpdate():
                raise RequestError("a skeleton has no kind, neutral or tags", mend="Send them with its .amc")
            return
        clips = clip_files(self.folder)
        for other in clips:
            if other.stem == own.stem and other.name != own.name:
                raise RequestError(f"name: the folder already has a clip {other.name}", mend="Choose another name")
        names = {one.stem for one in clips} | {own.stem}
        if update.neutral is not None and update.neutral not in names:
            mend = did_you_mean(update.neutral, names)
            raise RequestError(f"neutral: the folder has no clip {update.neutral[:40]!r}", mend=mend)

    def _put(self, file: Path, update: EntryUpdate) -> None:
        with locked(self.folder / LOCK):
            self._check_request(Path(file.name), update)
            settings_file = self.folder / FILE_NAME
            fresh = written_beside(settings_file, file.stem, update) if update != EntryUpdate() else None
            os.replace(file, self.folder / file.name)  # first, as an entry without its clip fails the whole job
            if fresh is not None:
                os.replace(fresh, settings_file)
            descriptor = os.open(self.folder, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)


async def _write(file: Path, body: AsyncIterator[bytes], check_quota: Callable[[], None]) -> None:
    """Writes and syncs a body, in a thread, as a disk may be slow."""
    with file.open("wb", buffering=0) as sink:
        buffered = bytearray()
        async for chunk in body:
            buffered += chunk
            if len(buffered) >= PIECE:
                await asyncio.to_thread(sink.write, bytes(buffered))
                buffered.clear()
                await asyncio.to_thread(check_quota)
        await asyncio.to_thread(sink.write, bytes(buffered))
        await asyncio.to_thread(check_quota)
        await asyncio.to_thread(os.fsync, sink.fileno())


async def _check(file: Path, bank: Path, settings: ClipSettings) -> None:
    """Reads a clip in another process, where it may take long or crash without harm. Raises ClipError."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "motionsplice.precompute.job.check"),
        *(str(file), str(bank), orjson.dumps(settings.reading).decode()),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
    )
    try:
        async with asyncio.timeout(CHECK_SECONDS):
            output, _ = await process.communicate()
    except TimeoutError:
        raise ClipError(f"reading the clip took more than {CHECK_SECONDS:g} s", file=file.name) from None
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    try:
        problem = orjson.loads(output)
    except orjson.JSONDecodeError:
        raise ClipError("the clip could not be read", file=file.name, mend="Send a smaller file") from None
    if problem:
        raise ClipError(problem["problem"], file=file.name, place=problem["place"], mend=problem["mend"])


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """Holds a lock across processes. A process that is killed releases it."""
    with file.open("ab") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
