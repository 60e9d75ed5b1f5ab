"""Records what this process does to the files below a folder, and lets chosen operations fail."""

from __future__ import annotations

import builtins
import io
import os
import shutil
import stat
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal
from unittest.mock import patch

Kind = Literal["open", "create", "write", "sync", "sync names", "rename", "remove", "mkdir"]


@dataclass(frozen=True)
class Operation:
    """What was done.

    Attributes:
        kind: `open` is for reading, `create` for writing; `sync` is of a file's contents, `sync names` of the names in
            a folder.
        path: The file or folder; of a rename, the new name.
        source: The old name, of a rename.
        inode: The file's number, which it keeps when it is renamed.
        place: Where bytes are written.
        data: The bytes.
    """

    kind: Kind
    path: Path
    source: Path | None = None
    inode: int = 0
    place: int = 0
    data: bytes = b""


@dataclass
class Disk:
    """The operations on files below `folder`, in order. Number `fails_at` of those of a kind fails with `error`."""

    folder: Path
    kind: Kind | None = None
    fails_at: int = 0
    error: int = 0
    log: list[Operation] = field(default_factory=list)
    failed: bool = False
    _seen: int = 0

    def note(self, operation: Operation) -> None:
        """Logs an operation that is about to happen. Raises OSError if it is to fail."""
        if not operation.path.is_relative_to(self.folder):
            return
        if operation.kind == self.kind:
            self._seen += 1
            if self._seen == self.fails_at:
                self.failed = True
                raise OSError(self.error, os.strerror(self.error), str(operation.path))
        self.log.append(operation)


class Written(io.FileIO):
    """A file whose writes are logged. One that fails has written the first half."""

    def __init__(self, disk: Disk, path: Path) -> None:
        super().__init__(path, "w")
        self._disk, self._path, self._inode = disk, path, os.fstat(self.fileno()).st_ino
        disk.log[-1] = Operation("create", path, inode=self._inode)

    def write(self, data: Any, /) -> int:
        piece = bytes(data)
        try:
            self._disk.note(Operation("write", self._path, inode=self._inode, place=self.tell(), data=piece))
        except OSError:
            super().write(piece[: len(piece) // 2])
            raise
        return super().write(piece) or 0


@contextmanager
def recorded(disk: Disk) -> Iterator[Disk]:
    """Has the operations of this process logged while the context lasts."""
    opened, opened_low, sync = io.open, os.open, os.fsync

    def open_file(file: Any, mode: str = "r", *args: Any, **settings: Any) -> Any:
        path = Path(file).absolute() if isinstance(file, str | os.PathLike) else Path()
        if mode != "wb" or not path.is_relative_to(disk.folder):
            disk.note(Operation("open", path))
            return opened(file, mode, *args, **settings)
        disk.note(Operation("create", path))
        return io.BufferedWriter(Written(disk, path))

    def open_low(path: Any, *args: Any, **settings: Any) -> int:
        if isinstance(path, str | os.PathLike):
            disk.note(Operation("open", Path(path).absolute()))
        return opened_low(path, *args, **settings)

    def synced(descriptor: int) -> None:
        path, found = Path(os.readlink(f"/proc/self/fd/{descriptor}")), os.fstat(descriptor)
        disk.note(Operation("sync names" if stat.S_ISDIR(found.st_mode) else "sync", path, inode=found.st_ino))
        sync(descriptor)

    def renamed(real: Callable[..., None]) -> Callable[..., None]:
        def rename(source: Any, target: Any, **settings: Any) -> None:
            old, new = Path(source).absolute(), Path(target).absolute()
            disk.note(Operation("rename", new, old, os.stat(old).st_ino))
            real(source, target, **settings)

        return rename

    def named(real: Callable[..., None], kind: Kind) -> Callable[..., None]:
        def change(path: Any, *args: Any, **settings: Any) -> None:
            if kind == "remove" or not os.path.lexists(path):
                disk.note(Operation(kind, Path(path).absolute()))
            real(path, *args, **settings)

        return change

    with ExitStack() as patches:
        for target, name, replaced in (
            *((io, "open", open_file), (builtins, "open", open_file), (os, "open", open_low), (os, "fsync", synced)),
            *((os, name, renamed(getattr(os, name))) for name in ("replace", "rename")),
            *((os, name, named(getattr(os, name), "remove")) for name in ("unlink", "remove")),
            *((os, "mkdir", named(os.mkdir, "mkdir")), (shutil, "_USE_CP_SENDFILE", False)),
        ):
            patches.enter_context(patch.object(target, name, replaced))
        yield disk
