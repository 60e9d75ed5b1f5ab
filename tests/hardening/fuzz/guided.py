"""`python -m tests.hardening.fuzz.guided DOOR FOLDER RUNS EMPTY`: inputs through a door, guided by coverage (atheris).

Fills FOLDER with the corpus, a tally and the inputs that led to what must not be, and adds to what earlier runs left
there. EMPTY is for the files of inputs.
"""

from __future__ import annotations

import os
import resource
import sys
import time
from pathlib import Path
from random import Random

import atheris

import motionsplice
from tests.hardening.fuzz.door import Door, covered_by, door_of
from tests.hardening.fuzz.harness import Tally, Visitor

LONGEST = 1024  # bytes of choices, of which generators use up to a few hundred
SEEDS = 64  # inputs to begin with
EVERY = 500  # inputs, after which the tally is written: the fuzzer does not return
MOST_CHANGES = 4  # of an input at once
MOST_REPEATED = 30  # inputs that are made for each one that is new, at most
HANGING = 60  # seconds, after which the fuzzer ends with the input


def main(name: str, folder: Path, runs: int, empty: Path) -> None:
    """Runs the fuzzer, which ends the process."""
    corpus = folder / "corpus"
    corpus.mkdir(parents=True, exist_ok=True)
    for number in range(SEEDS):
        (corpus / f"seed{number}").write_bytes(Random(f"{name} {number}").randbytes(LONGEST))
    tally = Tally.read(folder / "tally.json")
    visitor = Visitor(_instrumented(name), folder / "bad", empty, tally)
    end, earlier, before, least = tally.inputs + runs, tally.seconds - time.process_time(), tally.memory, _most_memory()

    def visit(data: bytes) -> None:
        if visitor.visit(data) and (tally.inputs % EVERY == 0 or tally.inputs == end):
            tally.seconds = earlier + time.process_time()
            tally.memory = max(before, _most_memory() - least)
            tally.write(folder / "tally.json")
            if tally.inputs == end:
                os._exit(0)

    def changed(data: bytes, longest: int, seed: int) -> bytes:
        """Returns other bytes: in half of the cases new ones, as most small changes choose the same."""
        choose = Random(seed)
        if choose.randrange(2):
            return choose.randbytes(LONGEST)
        data = visitor.used if data.startswith(visitor.used) else data  # others choose nothing
        for _ in range(choose.randint(1, MOST_CHANGES)):
            data = atheris.Mutate(data, longest)
        return data

    options = [
        f"-runs={MOST_REPEATED * runs}",
        f"-max_len={LONGEST}",
        f"-timeout={HANGING}",
        "-rss_limit_mb=0",
        f"-seed={1 + tally.inputs}",
        "-len_control=0",
    ]
    atheris.Setup(["fuzz", str(corpus), *options, f"-artifact_prefix={folder}/"], visit, custom_mutator=changed)
    atheris.Fuzz()


def _most_memory() -> int:
    """Returns the bytes of memory that this process has had at once."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _instrumented(name: str) -> Door:
    """Returns a door, behind which only its own modules are instrumented: Numba cannot compile what is."""
    others = [module for module in _modules() if not covered_by(name, module)]
    with atheris.instrument_imports(include=["motionsplice"], exclude=others):
        return door_of(name)


def _modules() -> list[str]:
    """Returns the names of all modules of the package."""
    root = Path(motionsplice.__file__).parent
    return [
        ".".join(("motionsplice", *file.relative_to(root).with_suffix("").parts)).removesuffix(".__init__")
        for package in ("motion", "precompute", "runtime", "service", "sending", "commands", "pictures")
        for file in (root / package).rglob("*.py")
    ]


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))
