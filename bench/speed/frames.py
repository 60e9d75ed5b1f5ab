"""Measures the time per character and frame: `python -m bench.speed.frames [--bank BANK] [--out frames.json]`.

Rows of the tables:

splice, naive, none   One call of `Evaluator.evaluate` for all characters, including its checks. The methods are the
                      splice with posture `relative`, plain replacement, and the locomotion alone. Each writes into its
                      own poses.
copy                  The floor: `np.take` of the rows that the splices read, two neighbouring rows of each mapped
                      table per character, and a copy of as many bytes as the poses have. The rows are known in
                      advance, so this is memory traffic alone. But it also writes the rows and prefetches nothing, so
                      kernels can be faster than this when rows come from memory.
NumPy                 The same splices in NumPy, without kernels (`bench.speed.numpy_twin`), in separate rounds.
the same in C++       The same algorithm in C++: the evaluator of clients/cpp, compiled by g++ -O3 -march=native, over
                      tables of its own, in turns with the kernels. Left out, with the reason, without g++.
--against LIBRARY     A shared library of yours, such as your engine's sampler, likewise. It needs the three functions
                      of bench/speed/sampler.h. How far its poses are from the kernels' is printed.
                      bench/speed/ozz_twin.cpp makes one of ozz-animation.

All rows of a table run interleaved in one process. Each call has its own requests, and ratios are taken within rounds.
A time is that of a whole call divided by its number of characters.

warm     After an untimed call; small batches run many times in a row.
cold     Before each call, more memory is written than the caches hold.
paced    One call per 60 Hz tick, with sleep in between, so that the core slows down and others use its caches.
single   One character per call, many times in a row: by request, also to a kernel that takes each array as an argument,
         and by name. The extra cost over a character in a batch is Python's overhead.

The times depend on the machine and its other load. The slowest round is mostly due to other processes.
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
from bench.speed import cpp_twin, frame_tables, roofline, unpacked
from bench.speed.numpy_twin import NumpyTwin
from bench.speed.sampler import Sampler
from bench.speed.workload import RATE, SETS, Copy, Scene, evaluation, request_sets, twin_evaluation
from motionsplice.cli import run
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import POSTURES, Memory
from motionsplice.runtime.splice import Splice

Tables = dict[str, list[Summary]]

ANY = Scene()
UNPACKED = "arrays as arguments"
BATCH, LARGE = 1000, 10_000  # characters; batches of LARGE or more run fewer rounds
COLD, PACED = (1, 100, 1000), (1, 100, 1000)
HOT = 100  # least number of characters per turn of a hot loop; smaller batches are called several times


def main(
    bank: Annotated[Path | None, typer.Option(help="A bank; default: a generated one")] = None,
    joints: Annotated[int, typer.Option(help="Joints of the generated bank")] = Size.joints,
    clips: Annotated[int, typer.Option(help="Clips of the generated bank")] = Size.clips,
    seconds: Annotated[float, typer.Option(help="Length of the generated bank's clips")] = Size.seconds,
    characters: Annotated[list[int] | None, typer.Option(help="Batch size; may be given several times")] = None,
    rounds: Annotated[int, typer.Option(min=2, help="Rounds of each table")] = 300,
    ticks: Annotated[int, typer.Option(min=2, help="60 Hz ticks per paced row")] = 300,
    threads: Annotated[int, typer.Option(min=2, help="Number of threads to compare with one")] = 2,
    against: Annotated[Path | None, typer.Option(help="A library that is timed too: see bench/speed/sampler.h")] = None,
    out: Annotated[Path | None, typer.Option(help="JSON file for the results")] = None,
) -> None:
    """Prints the time of a splice, beside plain replacement and a copy of the same number of bytes."""
    with tempfile.TemporaryDirectory() as folder:
        opened = Bank.open(bank) if bank else generate(Path(folder) / "bank", Size(joints, clips, seconds))
        evaluator = Evaluator(opened)
        evaluator.warm()
        libraries = {} if cpp_twin.MISSING else {"the same algorithm in C++": cpp_twin.compiled(Path(folder))}
        if against:
            libraries[against.name] = against
        samplers = {name: Sampler(path, evaluator) for name, path in libraries.items()}
        tables = {
            "batches": batches(evaluator, characters or [1, 10, 100, 1000, 10_000], rounds),
            "scenes": scenes(evaluator, rounds),
            "forms": forms(evaluator, rounds),
            "threads": on_threads(opened, min(threads, numba.config.NUMBA_NUM_THREADS), rounds),  # type: ignore[attr-defined]
            "cold": cold(evaluator, rounds // 3),
            "paced": in_ticks(evaluator, ticks),
            "single": single_calls(evaluator, rounds),
        }
        if samplers:
            tables["libraries, random times"] = in_libraries(evaluator, samplers, ANY, rounds)
            tables["libraries, sequential times"] = in_libraries(evaluator, samplers, Scene(sequential=True), rounds)
        degrees = {
            name: np.degrees(one.difference(request_sets(opened, BATCH, ANY)[0])) for name, one in samplers.items()
        }
        for one in samplers.values():
            one.close()
        roof = roofline.measure(opened)
        about = {
            "joints": opened.skeleton.joint_count,
            "clips": len(opened.clips),
            "seconds": sum(clip.duration for clip in opened.clips),
            "bytes": sum(table.nbytes for table in opened.tables.values()),
        }
    frame_tables.show(about, tables, roof)
    for name, angle in degrees.items():
        print(f"{name}: its rotations differ from the kernels' by {angle:.4f} degrees (median).")
    if cpp_twin.MISSING:
        print(f"The row of the same algorithm in C++ is left out: {cpp_twin.MISSING}.")
    if out:
        out.write_text(json.dumps(as_json(about, tables, roof), indent=1))


def as_json(about: Mapping[str, object], tables: Tables, roof: roofline.Roofline) -> dict[str, Any]:
    """Returns the content of the JSON file. Times are seconds per character and frame."""
    return {
        "bank": dict(about),
        "tables": {name: [asdict(one) for one in rows] for name, rows in tables.items()},
        "roofline": asdict(roof),
    }


def batches(evaluator: Evaluator, sizes: list[int], rounds: int) -> list[Summary]:
    """Times warm batches of several sizes: random pairs of clips at random times."""
    twin, rows = NumpyTwin(evaluator.bank), []
    for count in sizes:
        work = methods(evaluator, count, ANY)
        rows += summaries(warm(work, count, rounds), count)
        work["NumPy"] = twin_evaluation(twin, evaluator, request_sets(evaluator.bank, count, ANY, seed=len(work)))
        # In separate rounds, because it evicts the others' data from the caches.
        rows += [one for one in summaries(warm(work, count, max(rounds // 10, 2)), count) if one.what == "NumPy"]
    return rows


def warm(work: Mapping[str, Work], count: int, rounds: int) -> dict[str, Floats]:
    """Returns the seconds of calls in a hot loop. Small batches have more calls per round, large ones fewer rounds."""
    calls = max(HOT // count, 1)
    return interleaved(work, max(rounds // (5 if count >= LARGE else 1), 2), calls)


def scenes(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """Times warm batches in which characters play one pair or many, at sequential or random times."""
    rows = []
    for scene in (Scene(many, sequential) for many in (False, True) for sequential in (True, False)):
        for one in summaries(warm(methods(evaluator, BATCH, scene), BATCH, rounds), BATCH):
            if one.what == "splice":
                rows.append(Summary(**(vars(one) | {"what": scene.label})))
    return rows


def forms(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """Times warm batches with each posture, and the world positions of existing poses."""
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
    """Times warm batches on one thread and on several."""
    rows = []
    for count in (100, BATCH, LARGE):
        work = {"one thread": evaluation(Evaluator(bank), request_sets(bank, count, ANY))}
        if threads > 1:
            sets = request_sets(bank, count, ANY, seed=1)
            work[f"{threads} threads"] = evaluation(Evaluator(bank, threads=threads), sets)
        rows += summaries(warm(work, count, rounds), count, ["one thread"])
    return rows


def cold(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """Times batches whose rows, poses and code must come from memory."""
    rows = []
    for count in COLD:
        rows += summaries(interleaved(methods(evaluator, count, ANY), max(rounds, 2), before=evict_caches), count)
    return rows


def in_ticks(evaluator: Evaluator, ticks: int) -> list[Summary]:
    """Times batches at 60 Hz, one piece of work per tick, with all sizes and methods in turn."""
    scene = Scene(sequential=True)
    work = {(count, name): one for count in PACED for name, one in methods(evaluator, count, scene).items()}
    seconds = paced({f"{count} {name}": one for (count, name), one in work.items()}, ticks)
    rows = []
    for count in PACED:
        own = {name: seconds[f"{size} {name}"] for size, name in work if size == count}
        rows += summaries(own, count)
    return rows


def single_calls(evaluator: Evaluator, rounds: int) -> list[Summary]:
    """Times calls of one character, as in a small game: by request into existing poses, and by name."""
    work = methods(evaluator, 1, ANY)
    work[UNPACKED] = unpacked.evaluation(evaluator, request_sets(evaluator.bank, 1, ANY, seed=len(work)))
    first, last = evaluator.bank.clips[0], evaluator.bank.clips[-1]
    times = np.random.default_rng(0).random(SETS) * first.duration
    work["by name"] = lambda number: evaluator.pose(Splice(first.name, last.name), times[number % SETS])
    return summaries(warm(work, 1, rounds), 1, ("naive", "copy", UNPACKED))


def in_libraries(evaluator: Evaluator, samplers: Mapping[str, Sampler], scene: Scene, rounds: int) -> list[Summary]:
    """Times warm batches by the kernels and by libraries.

    Sequential times go back by half a second whenever all sets were used. A library that seeks from where it was takes
    longer in these rounds, so they show in its slowest times, but not in medians.
    """
    rows = []
    for count in (1, 100, BATCH, LARGE):
        work = {"splice": evaluation(evaluator, request_sets(evaluator.bank, count, scene))}
        for seed, (name, sampler) in enumerate(samplers.items(), 1):
            sets = request_sets(evaluator.bank, count, scene, seed=seed)
            work[name] = sampler.evaluation(sets, evaluator.poses(count))
        rows += summaries(warm(work, count, rounds), count, list(work))
    return rows


def methods(evaluator: Evaluator, count: int, scene: Scene) -> dict[str, Work]:
    """Returns the work of the three methods and of the floor, `copy`."""
    bank = evaluator.bank
    work = {
        method: evaluation(evaluator, request_sets(bank, count, scene, method, seed=seed))
        for seed, method in enumerate(("splice", "naive", "none"))
    }
    return work | {"copy": Copy(bank, request_sets(bank, count, scene, seed=len(work))).run}


if __name__ == "__main__":
    run(lambda: typer.run(main))
