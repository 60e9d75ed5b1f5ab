from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from bench.generated import Size, generate
from bench.rounds import Summary, Work
from bench.speed import cpp_twin, flatness, frames, roofline
from bench.speed.frame_tables import summary_table
from bench.speed.memory import FIELDS, state_of, table_pages
from bench.speed.numpy_twin import NumpyTwin
from bench.speed.sampler import Sampler
from bench.speed.speed_charts import speed_chart
from bench.speed.workload import SETS, Copy, Scene, request_sets
from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import METHODS, Poses, Requests
from motionsplice.runtime.splice import Splice

MANY = Scene()
needs_gcc = pytest.mark.skipif(bool(cpp_twin.MISSING), reason=cpp_twin.MISSING)


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Bank:
    return generate(tmp_path_factory.mktemp("generated") / "bank", Size(joints=22, clips=6, seconds=4.0))


@needs_gcc
def test_the_twin_in_cpp_agrees_with_the_kernels(generated: Bank, tmp_path: Path) -> None:
    evaluator, sets = Evaluator(generated), request_sets(generated, 60, MANY)
    sets[3].start[:] = 0.3
    ours, theirs = evaluator.poses(60), evaluator.poses(60)
    evaluator.evaluate(sets[3], ours)
    with closing(Sampler(cpp_twin.compiled(tmp_path), evaluator)) as twin:
        twin.evaluation(sets, theirs)(3)
        assert twin.difference(sets[3]) < 1e-6
    np.testing.assert_allclose(theirs.root_positions, ours.root_positions, atol=1e-6)
    np.testing.assert_allclose(theirs.rotations, ours.rotations, atol=1e-6)


def test_without_a_compiler_the_row_in_cpp_is_left_out_with_the_reason(
    generated: Bank, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cpp_twin, "MISSING", "g++ is not installed")
    frames.main(bank=generated.path, characters=[1], rounds=2, ticks=2)
    printed = capsys.readouterr().out
    assert "left out: g++ is not installed" in printed
    assert "libraries in C" not in printed


LIBRARY = """
#include <stddef.h>
#include "sampler.h"
void* sampler_open(const char* bank) { return OPENED; }
int sampler_evaluate(void* sampler, const sampler_request* requests, int32_t count, float* rotations, float* roots) {
    for (int k = 0; k < 4 * 22 * count; ++k) rotations[k] = k % 4 == 3 ? LENGTH : 0.0f;
    for (int k = 0; k < count; ++k) roots[3 * k] = (float)requests[k].action_time;
    return 0;
}
#ifndef HALF
void sampler_close(void* sampler) {}
#endif
"""


def built(folder: Path, *options: str) -> Path:
    """Compiles LIBRARY."""
    (folder / "engine.c").write_text(LIBRARY)
    command = ["gcc", "-shared", "-fPIC", "-I", str(Path(frames.__file__).parent), *options]
    subprocess.run([*command, folder / "engine.c", "-o", folder / "engine.so"], check=True)
    return folder / "engine.so"


@needs_gcc
def test_a_library_is_given_the_moment_of_the_action_and_timed_beside_the_kernels(
    generated: Bank, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    engine, evaluator = built(tmp_path, "-DOPENED=(void*)bank", "-DLENGTH=1.0f"), Evaluator(generated)
    requests, poses = request_sets(generated, 3, MANY)[0], evaluator.poses(3)
    with closing(Sampler(engine, evaluator)) as sampler:
        sampler.evaluation([requests], poses)(0)
        assert sampler.difference(requests) > 0.05
    for k in range(3):
        own, other = (generated.clips[number[k]] for number in (requests.locomotion, requests.action))
        frame = evaluator.action_frames(Splice(own.name, other.name), requests.time[k : k + 1])[0]
        assert poses.root_positions[k, 0] == pytest.approx(frame / other.rate, abs=1e-5)
    frames.main(bank=generated.path, characters=[1], rounds=2, ticks=2, against=engine)
    printed = capsys.readouterr().out
    for times in ("random", "sequential"):
        assert f"Warm batches at {times} times: the kernels, and libraries in C" in printed
    assert "engine.so: its rotations differ from the kernels' by" in printed


@pytest.mark.parametrize("sequential", [False, True])
def test_a_library_gets_the_times_of_its_table(generated: Bank, sequential: bool) -> None:
    received: list[Sequence[Requests]] = []

    class Recorder(Sampler):
        def __init__(self) -> None:
            pass

        def evaluation(self, sets: Sequence[Requests], poses: Poses) -> Work:
            received.append(sets)
            return lambda number: number

    rows = frames.in_libraries(Evaluator(generated), {"engine": Recorder()}, Scene(sequential=sequential), 2)
    assert [row.what for row in rows] == ["splice", "engine"] * len(received)
    for sets in received:
        later = sets[1].time - sets[0].time
        assert np.isclose(later[later > 0.0], 1.0 / 60.0).all() == sequential


def test_a_small_ratio_is_printed_to_two_digits() -> None:
    one = Summary("splice", 1000, 3, 1e-6, 1e-6, 1e-6, 1e-6, {"engine": 0.0846, "copy": 1.234})
    table = summary_table("", [one])
    assert [next(iter(column.cells)) for column in table.columns][-2:] == ["0.085", "1.23"]


@needs_gcc
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-DOPENED=NULL", "-DLENGTH=1.0f"], "does not open the bank"),
        (["-DOPENED=(void*)bank", "-DLENGTH=1.0f", "-DHALF"], "sampler_close"),
        (["-DOPENED=(void*)bank", "-DLENGTH=0.0f"], "does not write unit quaternions"),
    ],
)
def test_a_library_that_cannot_be_compared_is_refused(
    generated: Bank, tmp_path: Path, options: list[str], words: str
) -> None:
    with pytest.raises(SettingsError, match=words):
        Sampler(built(tmp_path, *options), Evaluator(generated)).difference(request_sets(generated, 3, MANY)[0])
    with pytest.raises(SettingsError, match="cannot be used"):
        Sampler(tmp_path / "engine.c", Evaluator(generated))


@pytest.mark.parametrize("of", ["generated", "bank"])
def test_the_numpy_twin_agrees_with_the_kernels(of: str, request: pytest.FixtureRequest) -> None:
    bank: Bank = request.getfixturevalue(of)
    evaluator, twin = Evaluator(bank), NumpyTwin(bank)
    for requests in request_sets(bank, 60, MANY)[:5]:
        requests.start[:] = 0.4 * np.array([bank.clips[action].duration for action in requests.action])
        ours, theirs = evaluator.poses(60), evaluator.poses(60)
        evaluator.evaluate(requests, ours)
        twin.evaluate(requests, theirs)
        np.testing.assert_allclose(theirs.root_positions, ours.root_positions, atol=1e-5)
        np.testing.assert_allclose(np.abs(np.sum(theirs.rotations * ours.rotations, axis=-1)), 1.0, atol=2e-5)


def test_the_twin_finds_the_positions_of_characters(generated: Bank) -> None:
    requests, evaluator = request_sets(generated, 3, MANY)[0], Evaluator(generated)
    requests.method[:] = [METHODS[name] for name in ("splice", "naive", "none")]
    below, above = NumpyTwin(generated).places(requests)
    for k in range(3):
        own, other = (generated.clips[number[k]] for number in (requests.locomotion, requests.action))
        assert below.rows[k] + below.shares[k] == pytest.approx(own.first_row + requests.time[k] * own.rate)
        expected = {
            0: other.first_row + evaluator.action_frames(Splice(own.name, other.name), requests.time[k : k + 1])[0],
            1: other.first_row + (requests.time[k] % other.duration) * other.rate,
            2: own.first_row + requests.time[k] * own.rate,
        }[k]
        assert above.rows[k] + above.shares[k] == pytest.approx(expected, abs=1e-3)


def test_scenes_have_the_pairs_and_times_of_their_name(generated: Bank) -> None:
    for scene in (Scene(many, sequential) for many in (False, True) for sequential in (False, True)):
        sets = request_sets(generated, 50, scene)
        assert len(sets) == SETS
        assert (len({(a, b) for a, b in zip(sets[0].locomotion, sets[0].action, strict=True)}) > 1) == scene.many
        later = sets[1].time - sets[0].time
        assert np.isclose(later[later > 0.0], 1.0 / 60.0).all() == scene.sequential
        evaluator = Evaluator(generated)
        for one in sets:
            evaluator.evaluate(one, evaluator.poses(50))  # raises if a time lies outside its clip


def test_the_floor_copies_the_rows_of_the_splices_and_the_bytes_of_the_poses(generated: Bank) -> None:
    sets = request_sets(generated, 7, MANY)
    copy = Copy(generated, sets)
    columns = generated.layout.lower.columns + generated.layout.upper.columns
    assert sum(room.nbytes for room in copy._room) == 7 * 2 * 4 * columns
    assert copy._out.shape == (7, 3 + 4 * 22)
    copy.run(3)
    for room, table, place in zip(copy._room, ("lower", "upper"), NumpyTwin(generated).places(sets[3]), strict=True):
        copied = np.frombuffer(room.tobytes(), np.float32).reshape(7, 2, -1)
        np.testing.assert_array_equal(copied[:, 0], generated.tables[table][place.rows])
        np.testing.assert_array_equal(copied[:, 1], generated.tables[table][place.rows + 1])


def test_a_small_run_prints_tables_and_writes_them(
    generated: Bank, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "frames.json"
    frames.main(bank=generated.path, characters=[1, 20], rounds=3, ticks=2, out=out)
    document = json.loads(out.read_text())
    assert set(document) == {"bank", "tables", "roofline"}
    assert document["bank"]["joints"] == 22
    tables = document["tables"]
    names = {"batches", "scenes", "forms", "threads", "cold", "paced", "single"}
    libraries = {"libraries, random times", "libraries, sequential times"}
    assert set(tables) == (names if cpp_twin.MISSING else names | libraries)
    assert [(row["characters"], row["what"]) for row in tables["batches"]] == [
        (count, what) for count in (1, 20) for what in ("splice", "naive", "none", "copy", "NumPy")
    ]
    for rows in tables.values():
        for row in rows:
            assert set(row) == {field.name for field in fields(Summary)}
            assert 0.0 < row["median"] <= row["p95"] <= row["p99"] <= row["worst"]
    printed = capsys.readouterr().out
    for title in ("Warm batches", "Cold batches", "60 Hz ticks", "Single calls", "Roofline"):
        assert title in printed


def test_the_roofline_counts_the_bytes_of_rows_request_and_pose(generated: Bank) -> None:
    columns = generated.layout.lower.columns + generated.layout.upper.columns
    assert roofline.splice_bytes(generated) == 8 * columns + 64 * roofline.LOOK_UPS + 32 + 4 * (3 + 4 * 22)
    roof = roofline.Roofline(bytes=1000, operations=500, memory=1e9, cache=4e9, arithmetic=1e10)
    assert (roof.from_memory, roof.from_cache, roof.computing) == pytest.approx((1e-6, 2.5e-7, 5e-8))


def test_flatness_measures_and_draws_every_x(generated: Bank) -> None:
    series = flatness.measure(3, lengths=(10, 60, 160), counts=(2, 3, 4))
    assert [one.name for one in series] == [
        "clip length, everywhere",
        "clip length, same rows",
        "clips in the bank, everywhere",
        "clips in the bank, same rows",
        "time since start",
    ]
    assert series[0].x == series[1].x == (10.0, 60.0, 160.0)
    assert series[4].x == (25.0, 75.0, 125.0)
    assert all(len(one.splice) == len(one.naive) == len(one.x) and min(one.splice) > 0.0 for one in series[:4])
    summary = Summary("splice", 1, 3, 1e-6, 1e-6, 1e-6, 1e-6, {})
    assert speed_chart(series, [summary, replace(summary, characters=10)]).startswith(b"\x89PNG")


@pytest.mark.parametrize("play", [flatness.everywhere, flatness.same_rows])
def test_only_same_rows_are_limited_to_the_pool(generated: Bank, play: Callable[[Bank], list[Requests]]) -> None:
    touched = {record.item() for one in play(generated) for record in one.records}
    assert (len(touched) <= flatness.POOL) == (play is flatness.same_rows)


def test_times_since_a_start_lie_within_the_span(generated: Bank, tmp_path: Path) -> None:
    bank = generate(tmp_path / "bank", Size(joints=15, clips=2, seconds=120.0))
    times = np.concatenate([one.time for one in flatness.since(bank, 50.0)])
    assert 50.0 <= times.min() < times.max() <= 100.0


def test_state_is_the_request_and_the_memory(generated: Bank) -> None:
    state = state_of(generated)
    assert (state.request, state.memory, state.pose) == (32, 8 * (4 + 6), 4 * (3 + 4 * 22))


def test_pages_are_summed_over_the_tables_only() -> None:
    smaps = """\
7f00-7f01 r--s 00000000 fe:00 1  /bank/tables/a.npy
Size:                 12 kB
Rss:                   8 kB
Pss:                   4 kB
Shared_Clean:          8 kB
VmFlags: rd sh
7f02-7f03 r--s 00000000 fe:00 2  /bank/tables/b.npy
Size:                  4 kB
Private_Dirty:         4 kB
7f04-7f05 rw-p 00000000 00:00 0  [heap]
Size:                100 kB
Rss:                 100 kB
"""
    expected = dict.fromkeys(FIELDS, 0) | {
        "Size": 16384, "Rss": 8192, "Pss": 4096, "Shared_Clean": 8192, "Private_Dirty": 4096,
    }  # fmt: skip
    assert table_pages(smaps, "/bank") == expected
