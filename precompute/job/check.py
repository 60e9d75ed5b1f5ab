"""Checks whether a file can become a clip of a bank.

`python -m motionsplice.precompute.job.check FILE MANIFEST_FOLDER SETTINGS`, with the arguments for `read_clip` as JSON

The service runs this for every uploaded file, in a separate process: the file may be hostile, and parsing holds the
GIL. It prints a JSON map of `problem`, `place` and `mend`, which is empty if the file is fine.
"""

from __future__ import annotations

import json
import resource
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motionsplice.motion.errors import ClipError, FormatError, MotionError
from motionsplice.motion.formats.asf_amc import parse_skeleton
from motionsplice.motion.formats.files import clips_in, read_bytes
from motionsplice.motion.formats.reading import read_clip
from motionsplice.motion.retarget.onto_rig import onto_rig
from motionsplice.motion.retarget.rig import Rig
from motionsplice.precompute.alignment.alignment import SHORTEST_CLIP
from motionsplice.runtime.format.manifest import Manifest

MEMORY, MEMORY_PER_BYTE = 2 * 2**30, 12  # bytes of address space: for the process, and per byte of the file


def check(file: Path, bank: Path, settings: Mapping[str, Any]) -> None:
    """Reads a file as the offline job would, and moves it to the bank's skeleton. Raises MotionError if either fails.

    It does not check for a gait; the job itself does.
    """
    if file.suffix == ".asf":
        parse_skeleton(read_bytes(file))
        return
    if len(names := clips_in(file)) > 1:
        raise FormatError(f"it has {len(names)} animations", mend="Upload a file for each")
    reading, manifest = read_clip(file, **settings), Manifest.read(bank)
    clip = onto_rig(reading.clip, reading.roles, Rig(manifest.skeleton, manifest.roles)).clip
    if clip.duration < SHORTEST_CLIP:
        problem = f"it lasts {clip.duration:.3f} s, too short to find its gait"
        raise ClipError(problem, mend=f"Use at least {SHORTEST_CLIP} s, better two strides or more")


def problem_of(file: Path, bank: Path, settings: Mapping[str, Any]) -> dict[str, str]:
    """Returns the problem with a file, without its folder's name; empty if the file is fine."""
    try:
        check(file, bank, settings)
    except MotionError as error:
        problem = {"problem": error.problem, "place": error.place, "mend": error.mend}
        return {key: text.replace(f"{file.parent}/", "") for key, text in problem.items()}
    except MemoryError:
        return {"problem": "reading it takes too much memory", "place": "", "mend": "Cut it into shorter clips"}
    return {}


if __name__ == "__main__":
    file, bank, settings = sys.argv[1:]
    most = MEMORY + MEMORY_PER_BYTE * Path(file).stat().st_size
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    print(json.dumps(problem_of(Path(file), Path(bank), json.loads(settings))))
