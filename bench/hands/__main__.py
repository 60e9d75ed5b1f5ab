"""How well hands are aligned to bodies, against generated truth: `python -m bench.hands [CLIPS]`.

sequences    gestures like the paper's (6 to 34 in 280 to 570 frames at 60 Hz, each of the hands' 0.2 to 1 times as
             large as the body's, tempo 0.6 to 1.6, 2 mm of noise): frames by which alignments are off the truth, beside
             plain dynamic time warping of positions and of derivatives (the paper's figure 3) in the same band, as seen
             from the trunks; and of derivatives that are filtered, and a result that is steadied, as ours are.
real         the arms of each clip in a folder, and once more 0.2 to 1 times as large, turned, and in another tempo.
mismatch     by which a user is warned of hands that do not do what the body does.
pairs        equal gestures, of which the hands' performer repeats one: with and without three pairs of frames.
time         one hand of 569 frames, the paper's longest (10.95 s there).
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.hands.accuracy import constrained, errors, mismatches
from bench.hands.sequences import captured, sequence
from bench.hands.timing import timing
from motionsplice.cli import run

PARTS = ((0.2, 0.4), (0.4, 0.7), (0.7, 1.0))  # sizes of the hands' gestures


def main(
    clips: Annotated[Path | None, typer.Argument(help="A folder of real motion, whose arms are taken too")] = None,
    sequences: Annotated[int, typer.Option(min=1, help="Generated sequences")] = 50,
) -> None:
    """Prints what is found."""
    if clips is not None:
        errors("Real motion, once more in other tempo and size", captured(clips)).show()
    drawn = [sequence(seed) for seed in range(sequences)]
    errors(f"{sequences} sequences", drawn).show()
    mismatches(drawn).show()
    for size in PARTS:
        some = [sequence(1000 + seed, size) for seed in range(max(sequences // 3, 1))]
        errors(f"hands {size[0]:g} to {size[1]:g} times as large", some).show()
    constrained(sequences).show()
    timing().show()


if __name__ == "__main__":
    run(lambda: typer.run(main))
