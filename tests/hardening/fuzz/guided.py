"""`python -m tests.hardening.fuzz.guided DOOR FOLDER RUNS EMPTY`: inputs through a door, guided by coverage (atheris).

Fills FOLDER with the corpus, a tally and the inputs that led to what must not be. EMPTY is for the files of an input.
"""

from __future__ import annotations

import sys
from pathlib import Path
from random import Random

import atheris

import motionsplice
from tests.hardening.fuzz.door import Door, covered_by, door_of
from tests.hardening.fuzz.harness import Visitor

LONGEST = 4096  # bytes of choices; an input that is made of them may be longer
SEEDS = 64  # inputs to begin with
EVERY = 500  # inputs, after which the tally is written: the fuzzer does not return
HANGING = 60  # seconds, after which the fuzzer ends with the input


def main(name: str, folder: Path, runs: int, empty: Path) -> None:
    """Runs the fuzzer, which ends the process."""
    corpus = folder / "corpus"
    corpus.mkdir(parents=True, exist_ok=True)
    for number in range(SEEDS):
        (corpus / f"seed{number}").write_bytes(Random(f"{name} {number}").randbytes(LONGEST))
    visitor = Visitor(_instrumented(name), folder / "bad", empty)

    def visit(data: bytes) -> None:
        visitor.visit(data)
        if visitor.tally.inputs % EVERY == 0 or visitor.tally.inputs >= runs:
            visitor.tally.write(folder / "tally.json")

    options = [
        f"-runs={runs}",
        f"-max_len={LONGEST}",
        f"-timeout={HANGING}",
        "-rss_limit_mb=0",
        "-seed=1",
        "-len_control=0",
    ]
    atheris.Setup(["fuzz", str(corpus), *options, f"-artifact_prefix={folder}/"], visit)
    atheris.Fuzz()


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
