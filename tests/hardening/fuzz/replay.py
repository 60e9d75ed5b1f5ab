"""`python -m tests.hardening.fuzz.replay DOOR CORPUS`: how much of the code behind a door a corpus runs, as JSON."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import coverage

from tests.hardening.fuzz.door import DOORS, door_of

MOST = 3000  # inputs, the newest of which came last


def main(name: str, corpus: Path) -> None:
    """Prints, by module, the percentage of its lines and branches that were run."""
    prefixes = [prefix.replace(".", "/") for prefix in DOORS[name]]
    traced = coverage.Coverage(data_file=None, branch=True, include=[f"*/{one}*" for one in prefixes])
    traced.start()
    door = door_of(name)
    from tests.hardening.fuzz.harness import Visitor

    visitor = Visitor(door)
    for file in sorted(corpus.iterdir())[:MOST]:
        visitor.visit(file.read_bytes())
    traced.stop()
    visitor.close()
    report = io.StringIO()
    traced.report(file=report)
    print(json.dumps({line.split()[0]: line.split()[-1] for line in report.getvalue().splitlines() if ".py" in line}))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
