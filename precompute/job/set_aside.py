"""Readings that do not fit into memory, in a file without a name."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from io import SEEK_END, BufferedRandom
from pathlib import Path
from tempfile import TemporaryFile
from threading import Lock

import numpy as np

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.reading import Reading
from motionsplice.motion.quaternion import Floats


class SetAside:
    """Readings by key, for one process. The file is gone when the process ends, however it ends.

    A reading that cannot be written, or read back, is not here: its clip can be read again.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._alone = Lock()  # an executor may have threads
        self._places: dict[str, tuple[Reading, int, int]] = {}  # with one frame; where it begins; how many it has

    @cached_property
    def _file(self) -> BufferedRandom:
        self._folder.mkdir(parents=True, exist_ok=True)
        return TemporaryFile(dir=self._folder)

    def put(self, key: str, reading: Reading) -> None:
        """Sets a reading aside."""
        clip = reading.clip
        first = _of(reading, clip.root_positions[:1].copy(), clip.rotations[:1].copy())
        with suppress(OSError), self._alone:
            begin = self._file.seek(0, SEEK_END)
            for values in (clip.root_positions, clip.rotations):
                self._file.write(np.ascontiguousarray(values).data)
            self._places[key] = first, begin, clip.frame_count

    def get(self, key: str) -> Reading | None:
        """Returns a reading, equal to the last bit."""
        if key not in self._places:
            return None
        first, begin, frames = self._places[key]
        positions, rotations = np.empty((frames, 3)), np.empty((frames, first.clip.skeleton.joint_count, 4))
        with suppress(OSError), self._alone:
            self._file.seek(begin)
            missing = sum(one.nbytes - self._file.readinto(one.data.cast("B")) for one in (positions, rotations))
            if missing == 0:
                return _of(first, positions, rotations)
        return None

    def close(self) -> None:
        """Gives up the file."""
        self._places.clear()
        if "_file" in vars(self):
            self._file.close()


def _of(reading: Reading, positions: Floats, rotations: Floats) -> Reading:
    clip = reading.clip
    return replace(reading, clip=Clip.of_valid(clip.name, clip.skeleton, clip.rate, positions, rotations))
