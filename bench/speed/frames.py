"""Time per character-frame: `python -m bench.speed.frames [--bank BANK] [--out frames.json]`.

What the rows are:

splice, naive, none   one call of `Evaluator.evaluate` for all characters, checks included: the splice with posture
                      `relative`; plain replacement; the locomotion alone. Each into poses of its own.
copy                  the floor: `np.take` of the rows that such splices read, from the same mapped tables, two
                      neighbouring ones of each per character, and a copy of as many bytes as the poses have. Which
                      rows is known beforehand, so this is memory traffic alone. But rows are written too, and none is
                      fetched ahead: from memory, kernels can be faster.
NumPy                 the same splices, by arrays and without kernels (`bench.speed.numpy_twin`), in rounds of its own.

All of a table run in turns, in rounds of one process; each call has requests of its own, and ratios are taken within
rounds. A time is a whole call by its number of characters. Warm: after a call that is not timed, and small batches many
times in a row. Cold: before each call, more memory is written than the caches hold. Paced: one call per 60 Hz tick,
asleep in between, so that a core slows down and its caches are others'. Single calls: one character each, many times in
a row; what it costs more than a character of a batch is Python's.

Times hold for the machine and for what else it does. The slowest of some rounds is mostly somebody else's work.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import numba
import numpy as np
import typer

from bench.generated import Size, generate
from bench.rounds import Summary, Work, evict_caches, interleaved, paced, summaries
from bench.speed import frame_tables, roofline
from bench.speed.numpy_twin import NumpyTwin
from bench.speed.workload import RATE, SETS, Copy, Scene, evaluation, request_sets, twin_evaluation
from motionsplice.cli import run
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import POSTURES, Memory
from motionsplice.runtime.splice import Splice

Tables = dict[str, list[Summary]]

ANY = Scene()
BATCH, LARGE = 1000, 10_000  # characters; from LARGE on there are fewer rounds
COLD, PACED = (1, 100, 1000), (1, 100, 1000)
HOT = 100  # characters that small batches of a hot loop come to


def main(
    bank: Annotated[Path | None, typer.Option(help="A bank; a generated one if not given")] = None,
    joints: Annotated[int, typer.Option(help="Of a generated bank")] = Size.joints,
    clips: Annotated[int, typer.Option(help="Of a generated bank")] = Size.clips,
    seconds: Annotated[float, typer.Option(help="Length of a generated bank's clips")] = Size.seconds,
    characters: Annotated[list[int] | None, typer.Option(help="May be given more than once")] = None,
    rounds: Annotated[int, typer.Option(min=2)] = 300,
    ticks: Annotated[int, typer.Option(min=2, help="60 Hz ticks of each paced row")] = 300,
    threads: Annotated[int, typer.Option(min=2, help="Compared with one")] = 2,
    out: Annotated[Path | None, typer.Option(help="JSON file of the results")] = None,
) -> None:
    """Prints what a splice costs, against plain replacement and against a copy of the bytes that it touches."""
    with tempfile.TemporaryDirectory() as folder:
        opened = Bank.open(bank) if bank else generate(Path(folder) / "bank", Size(joints, clips, seconds))
        evaluator = Evaluator(opened)
        evaluator.warm()
        tables = {
            "batches": batches(evaluator, characters or [1, 10, 100, 1000, 10_000], rounds),
            "scenes": scenes(evaluator, rounds),
            "forms": forms(evaluator, rounds),
            "threads": on_threads(opened, min(threads, numba.config.NUMBA_NUM_THREADS), rounds),  # type: ignore[attr-defined]
            "cold": cold(evaluator, rounds // 3),
            "paced": in_ticks(evaluator, ticks),
            "single": single_calls(evaluator, rounds),
        }
        roof = roofline.measure(opened)
        about = {
            "joints": opened.skeleton.joint_count,
            "clips": len(opened.clips),
            "seconds": sum(clip.duration for clip in opened.clips),
            "bytes": sum(table.nbytes for table in opened.tables.values()),
        }
    frame_tables.show(about, tables, roof)
    if out:
        out.write_text(json.dumps(as_json(about, tables, roof), indent=1))


def as_json(about: Mapping[str, object], tables: Tables, roof: roofline.Roofline) -> dict[str, Any]:
    """What is written to the file: seconds per character-frame."""
    return {
        "bank": dict(about),
        "tables": {name: [asdict(one) for one in rows] for name, rows in tables.items()},
        "roofline": asdict(roof),
    }


def batches(evaluator: Evaluator, sizes: list[int], rounds: int) -> list[Summary]:
    """Warm batches of many sizes: any pair of clips at any time."""
    twin, told = NumpyTwin(evaluator.bank), []
    for count in sizes:
        work = methods(evaluator, count, ANY)
        told += summaries(warm(work, count, rounds), count)
        work["NumPy"] = twin_evaluation(twin, evaluator, request_sets(evaluator.bank, count, ANY, seed=len(work)))
        # In rounds apart, for it empties the caches of the others.
        told += [one for one in summaries(warm(work, count, max(rounds // 10, 2)), count) if one.what == "NumPy"]
    return told


def warm(work: Mapping[str, Work], count: int, rounds: int) -> dict[str, Floats]:
    """Seconds of calls in a hot loop, of small batches many, of large ones fewer."""
    calls = max(HOT // count, 1)
    return interleaved(work, max(rounds // (5 if count >= LARGE else 1), 2), calls)


def scenes(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """Warm batches in which characters play one pair or many, at times that go on or at any."""
    told = []
    for scene in (Scene(many, sequential) for many in (False, True) for sequential in (True, False)):
        for one in summaries(warm(methods(evaluator, BATCH, scene), BATCH, rounds), BATCH):
            if one.what == "splice":
                told.append(Summary(**(vars(one) | {"what": scene.label})))
    return told


def forms(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """Warm batches of every posture, and the world positions of poses that are there."""
    bank, joints = evaluator.bank, evaluator.bank.skeleton.joint_count
    work: dict[str, Work] = {"naive": methods(evaluator, BATCH, ANY)["naive"]}
    for seed, posture in enumerate(POSTURES, 1):
        sets = request_sets(bank, BATCH, ANY, posture=posture, seed=seed)
        work[f"posture {posture}"] = evaluation(evaluator, sets, Memory.begin(BATCH, RATE))
    poses, positions = evaluator.poses(BATCH), np.empty((BATCH, joints, 3), np.float32)
    evaluator.evaluate(request_sets(bank, BATCH, ANY)[0], poses)
    work["world positions"] = lambda _: evaluator.world_positions(poses, positions)
    return summaries(warm(work, BATCH, rounds), BATCH, against=["naive"])


def on_threads(bank: Bank, threads: int, rounds: int) -> list[Summary]:
    """Warm batches on one thread, and divided among some."""
    told = []
    for count in (100, BATCH, LARGE):
        work = {"one thread": evaluation(Evaluator(bank), request_sets(bank, count, ANY))}
        if threads > 1:
            sets = request_sets(bank, count, ANY, seed=1)
            work[f"{threads} threads"] = evaluation(Evaluator(bank, threads=threads), sets)
        told += summaries(warm(work, count, rounds), count, ["one thread"])
    return told


def cold(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """Batches whose rows, poses and code have to come from memory."""
    told = []
    for count in COLD:
        told += summaries(interleaved(methods(evaluator, count, ANY), max(rounds, 2), before=evict_caches), count)
    return told


def in_ticks(evaluator: Evaluator, ticks: int) -> list[Summary]:
    """Batches at 60 Hz: a tick is one of one size, and the next one of the next."""
    scene = Scene(sequential=True)
    work = {(count, name): one for count in PACED for name, one in methods(evaluator, count, scene).items()}
    seconds = paced({f"{count} {name}": one for (count, name), one in work.items()}, ticks)
    told = []
    for count in PACED:
        own = {name: seconds[f"{size} {name}"] for size, name in work if size == count}
        told += summaries(own, count)
    return told


def single_calls(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """One character a call, as a small game asks: by request, into room that is there, and by name."""
    work = methods(evaluator, 1, ANY)
    first, last = evaluator.bank.clips[0], evaluator.bank.clips[-1]
    times = np.random.default_rng(0).random(SETS) * first.duration
    work["by name"] = lambda number: evaluator.pose(Splice(first.name, last.name), times[number % SETS])
    return summaries(warm(work, 1, rounds), 1)


def methods(evaluator: Evaluator, count: int, scene: Scene) -> dict[str, Work]:
    """The three methods and the floor."""
    bank = evaluator.bank
    work = {
        method: evaluation(evaluator, request_sets(bank, count, scene, method, seed=seed))
        for seed, method in enumerate(("splice", "naive", "none"))
    }
    return work | {"copy": Copy(bank, request_sets(bank, count, scene, seed=len(work))).run}


if __name__ == "__main__":
    run(lambda: typer.run(main))
