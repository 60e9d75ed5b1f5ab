"""Checks whether a file can become a clip of a bank.

`python -m motionsplice.precompute.job.check FILE MANIFEST_FOLDER SKIP_FRAMES UNIT`

The service asks it of a file that was uploaded: in a process of its own, since a file may be hostile, and parsing holds
Python's lock. It prints a JSON map: the `problem`, its `place` and `mend`; empty if there is none.
"""

from __future__ import annotations

import json
import resource
import sys
from pathlib import Path

from motionsplice.motion.errors import ClipError, MotionError
from motionsplice.motion.formats.asf_amc import parse_skeleton
from motionsplice.motion.formats.files import read_bytes, read_clip
from motionsplice.precompute.alignment.baseline import SHORTEST_CLIP
from motionsplice.precompute.body.common_skeleton import onto_skeleton
from motionsplice.runtime.format.manifest import Manifest

MEMORY, MEMORY_PER_BYTE = 2 * 2**30, 12  # of address space: what a process takes, and what a file may


def check(file: Path, bank: Path, skip_frames: int = 0, unit: str | None = None) -> None:
    """Reads a file as the offline job would, and lays it on the bank's skeleton. Raises MotionError.

    Whether its legs show a gait is for the job itself to find out.
    """
    if file.suffix == ".asf":
        parse_skeleton(read_bytes(file))
        return
    reading, manifest = read_clip(file, skip_frames=skip_frames, unit=unit), Manifest.read(bank)
    clip = onto_skeleton(reading.clip, reading.roles, manifest.skeleton, manifest.roles)
    if clip.duration < SHORTEST_CLIP:
        raise ClipError(f"it lasts {clip.duration:.3f} s", mend=f"Give at least {SHORTEST_CLIP} s, better two strides")


def problem_of(file: Path, bank: Path, skip_frames: int, unit: str | None) -> dict[str, str]:
    """What is wrong with a file, naming no folder; empty if nothing is."""
    try:
        check(file, bank, skip_frames, unit)
    except MotionError as error:
        problem = {"problem": error.problem, "place": error.place, "mend": error.mend}
        return {key: text.replace(f"{file.parent}/", "") for key, text in problem.items()}
    except MemoryError:
        return {"problem": "it takes too much memory to be read", "place": "", "mend": "Cut it into shorter clips"}
    return {}


if __name__ == "__main__":
    file, bank, skip_frames, unit = sys.argv[1:]
    most = MEMORY + MEMORY_PER_BYTE * Path(file).stat().st_size
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    print(json.dumps(problem_of(Path(file), Path(bank), int(skip_frames), unit or None)))
