"""The job in executors that others opened: threads, and stand-ins for what can go wrong on a cluster."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import pytest

from motionsplice.motion.errors import SettingsError
from motionsplice.precompute.job import executor as executor_module
from motionsplice.precompute.job.executor import AHEAD, ExecutorError, in_executor
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.scheduler import executor_of
from motionsplice.precompute.job.workers import WorkerDiedError
from tests.conftest import CLIPS
from tests.precompute.job.test_job import files_of, write


class KilledWorker(Exception):  # noqa: N818
    """As Dask's."""


class Answering(Executor):
    """Ends each task by what `answer` returns or raises."""

    def __init__(self, answer: Callable[[Any], Any]) -> None:
        self.answer, self.submitted = answer, 0

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **_: Any) -> Future[Any]:
        self.submitted += 1
        future = Future[Any]()
        try:
            future.set_result(self.answer(arguments[-1]))
        except Exception as error:
            future.set_exception(error)
        return future


def test_an_executor_makes_the_same_bank_and_stays_open(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], run=CLIPS["run"])
    build_bank([clips], tmp_path / "bank", jobs=1)
    steps: list[tuple[str, int, int]] = []
    with ThreadPoolExecutor(2) as pool:
        build_bank([clips], tmp_path / "other", executor=pool, progress=lambda *step: steps.append(step))
        assert pool.submit(int, 7).result() == 7
    assert files_of(tmp_path / "other") == files_of(tmp_path / "bank")
    assert steps == [("reading", 1, 2), ("reading", 2, 2), ("aligning", 1, 2), ("aligning", 2, 2)]


def test_a_task_that_kills_its_workers_fails_alone() -> None:
    def answer(number: int) -> int:
        if number == 1:
            raise KilledWorker("Attempted to run task x on 4 different workers")
        return number

    made = dict(in_executor(Answering(answer), int, range(3)))
    assert (made[0], made[2]) == (0, 2)
    assert isinstance(made[1], WorkerDiedError)
    assert str(made[1]).startswith("every worker that tried it died. See the workers' logs")


@pytest.mark.parametrize(
    ("error", "problem"),
    [
        (BrokenProcessPool(), "the executor was closed or lost"),
        (ModuleNotFoundError("No module named 'motionsplice'"), "the workers cannot do the work: ModuleNotFoundError"),
    ],
)
def test_workers_that_cannot_work_end_the_job(error: Exception, problem: str) -> None:
    def answer(number: int) -> int:
        raise error

    with pytest.raises(ExecutorError, match=problem):
        list(in_executor(Answering(answer), int, range(3)))


def test_a_closed_pool_ends_the_job() -> None:
    pool = ProcessPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(ExecutorError, match="closed"):
        list(in_executor(pool, int, range(3)))


def test_workers_of_another_version_end_the_job(monkeypatch: pytest.MonkeyPatch) -> None:
    versions = iter(["ours", "theirs"])
    monkeypatch.setattr(executor_module, "version_of_method", lambda: next(versions))
    with ThreadPoolExecutor(1) as pool, pytest.raises(ExecutorError, match=r"another version.*on every worker"):
        list(in_executor(pool, int, [1]))


def test_only_so_many_tasks_are_submitted_at_a_time() -> None:
    executor = Answering(lambda number: number)
    outcomes = in_executor(executor, int, range(3 * AHEAD))
    next(outcomes)
    assert executor.submitted == AHEAD
    assert len(list(outcomes)) == 3 * AHEAD - 1


def test_a_job_that_is_stopped_gives_up_what_has_not_begun(tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", **{f"walk{number}": CLIPS["walk"].frames(0, 80 + number) for number in range(6)})
    begun = []

    def stop(stage: str, done: int, total: int) -> None:
        raise KeyboardInterrupt

    class Counting(ThreadPoolExecutor):
        def submit(self, *arguments: Any, **_: Any) -> Future[Any]:
            future = super().submit(*arguments)
            begun.append(future)
            return future

    with Counting(1) as pool, pytest.raises(KeyboardInterrupt):
        build_bank([clips], tmp_path / "bank", executor=pool, progress=stop)
    assert len(begun) == 6
    assert sum(future.cancelled() for future in begun) >= 3


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(
        SettingsError, match=r"Dask, which is not installed. Run `pip install 'motionsplice\[cluster\]'`"
    ):
        executor_of("tcp://127.0.0.1:1").__enter__()
