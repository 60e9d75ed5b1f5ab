"""`python -m service.exchange.check FILE`: is it a motion? A line of JSON says it. Run apart from the service."""

from __future__ import annotations

import sys
from pathlib import Path

import orjson

from motion.errors import MotionError
from motion.formats.files import read_clip


def problem_of(file: Path) -> str:
    """What is wrong with a motion file, as a sentence that names no folder; empty if nothing is."""
    try:
        read_clip(file)
    except MotionError as error:
        return str(error).replace(f"{file.parent}/", "")
    return ""


if __name__ == "__main__":
    sys.stdout.buffer.write(orjson.dumps({"problem": problem_of(Path(sys.argv[1]))}))
