"""Measures how close alignments of hands to bodies are to the true alignment: `python -m bench.hands [CLIPS]`.

real         With CLIPS: the arms of each clip serve as the body, and a copy of them as the hands. The copy is 0.2 to 1
             times as large, turned, and in another tempo.
sequences    Gestures like the paper's, 6 to 34 in 280 to 570 frames at 60 Hz. Each gesture of the hands is 0.2 to 1
             times as large as the body's, at a tempo of 0.6 to 1.6, with 2 mm of noise. Errors are in frames, beside
             those of plain dynamic time warping in the same band. Its features, relative to the trunk, are positions,
             derivatives (the paper's figure 3), and derivatives filtered like ours, whose result is also steadied.
mismatch     The number that warns users of hands whose gestures differ from the body's.
pairs        Identical gestures, some of which the hands' performer repeats: with and without three pairs of frames.
time         Seconds to align one hand of 569 frames, the paper's longest clip (10.95 s there).
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.hands.accuracy import constrained, errors, mismatches
from bench.hands.sequences import captured, sequence
from bench.hands.timing import timing
from motionsplice.cli import run

PARTS = ((0.2, 0.4), (0.4, 0.7), (0.7, 1.0))  # sizes of the hands' gestures, relative to the body's


def main(
    clips: Annotated[Path | None, typer.Argument(help="Folder of captured clips whose arms are aligned too")] = None,
    sequences: Annotated[int, typer.Option(min=1, help="Number of generated sequences")] = 50,
) -> None:
    """Prints the errors, the mismatch and the time of alignments of hands."""
    if clips is not None:
        errors("Captured arms against a copy of another size and tempo", captured(clips)).show()
    drawn = [sequence(seed) for seed in range(sequences)]
    errors(f"{sequences} generated sequences", drawn).show()
    mismatches(drawn).show()
    for size in PARTS:
        some = [sequence(1000 + seed, size) for seed in range(max(sequences // 3, 1))]
        errors(f"Hands {size[0]:g} to {size[1]:g} times as large", some).show()
    constrained(sequences).show()
    timing().show()


if __name__ == "__main__":
    run(lambda: typer.run(main))
