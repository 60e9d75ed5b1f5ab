"""Runs the service with a profiler: `python -m bench.service.profiled_server FILE serve BANK ...`.

SIGUSR1 starts the profiler. SIGUSR2 stops it and writes cProfile's statistics to FILE.
"""

from __future__ import annotations

import cProfile
import signal
import sys
from pathlib import Path

from motionsplice.cli import main as motionsplice


def main() -> None:
    """Installs the signals, and passes the rest of the command line to the service."""
    file, profile = Path(sys.argv.pop(1)), cProfile.Profile()

    def write(*_: object) -> None:
        profile.disable()
        whole = file.with_suffix(".new")
        profile.dump_stats(whole)
        whole.replace(file)

    signal.signal(signal.SIGUSR1, lambda *_: profile.enable())
    signal.signal(signal.SIGUSR2, write)
    motionsplice()


if __name__ == "__main__":
    main()
