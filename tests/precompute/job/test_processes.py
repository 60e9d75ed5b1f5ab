"""Work in processes. This module imports little, as each process that the tests start imports it too."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.job.processes import in_processes
from motionsplice.precompute.job.workers import Outcomes, WorkerDiedError, one_after_another


def in_two(function: Callable[[int], object], tasks: list[int]) -> Outcomes[int, object]:
    return in_processes(2, function, tasks)


def task(number: int) -> int:
    if number == 0:
        raise KeyboardInterrupt
    if number == 1:
        raise MemoryError
    if number == 2:
        raise ValueError("two")
    return number


@pytest.mark.parametrize("outcomes", [one_after_another, in_two])
def test_an_unexpected_error_fails_one_task_and_the_others_finish(
    outcomes: Callable[[Callable[[int], int], list[int]], Outcomes[int, int]],
) -> None:
    made = dict(outcomes(task, [1, 2, 3, 4]))
    assert (made[3], made[4]) == (3, 4)
    assert isinstance(made[1], MotionError)
    assert "not enough memory" in str(made[1])
    assert isinstance(made[2], MotionError)
    assert "unexpected ValueError: two. This is a bug" in str(made[2])


def of_a_program(number: int) -> list[str]:
    """Returns which parts of the program that started it this process has imported."""
    main = [str(sys.modules["__main__"].__file__)] if hasattr(sys.modules["__main__"], "__file__") else []
    return main + [name for name in ("matplotlib", "typer", "fastapi", "scipy.stats") if name in sys.modules]


def test_a_worker_imports_what_its_tasks_need_but_not_the_program() -> None:
    assert [made for _, made in in_two(of_a_program, [1, 2])] == [[], []]


def threads(number: int) -> str:
    return os.environ["OPENBLAS_NUM_THREADS"]


def test_a_worker_has_one_thread_and_our_environment_stays_unchanged() -> None:
    before = dict(os.environ)
    assert [made for _, made in in_two(threads, [1, 2])] == ["1", "1"]
    assert dict(os.environ) == before


KILLED = """
import os, signal
from multiprocessing import active_children
from motionsplice.precompute.job.processes import in_processes

for _ in in_processes(2, os.getpgid, [0] * 2):
    print(*(child.pid for child in active_children()), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_workers_end_with_their_parent() -> None:
    project = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    killed = subprocess.run([sys.executable, "-c", KILLED], env=project, capture_output=True, text=True, check=False)
    left = [int(number) for number in killed.stdout.split()]
    assert left
    for _ in range(100):
        if not (left := [one for one in left if Path(f"/proc/{one}").exists()]):
            return
        time.sleep(0.1)
    pytest.fail(f"processes {left} are still running")


def test_an_interrupt_ends_the_job() -> None:
    with pytest.raises(KeyboardInterrupt):
        list(one_after_another(task, [0, 3]))


def deadly(number: int) -> int:
    """Kills its process for 1, and crashes it for 2."""
    if number in (1, 2):
        os.kill(os.getpid(), {1: signal.SIGKILL, 2: signal.SIGSEGV}[number])
    return number


def test_a_process_that_dies_fails_its_task_and_the_others_finish() -> None:
    made = dict(in_two(deadly, list(range(12))))
    assert {number for number, result in made.items() if result == number} == {0, *range(3, 12)}
    assert isinstance(made[1], WorkerDiedError)
    assert "killed (SIGKILL), also when it worked alone; probably memory ran out. Cut the clip" in str(made[1])
    assert isinstance(made[2], WorkerDiedError)
    assert "crashed with SIGSEGV, also when it worked alone. This is a bug" in str(made[2])


def crowded(file: str) -> int:
    """Kills its process if another one is at the same work."""
    with open(file, "a") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.2)
    return os.getpid()


def test_tasks_that_die_only_together_all_finish_in_fewer_processes(tmp_path: Path) -> None:
    made = [result for _, result in in_processes(2, crowded, [str(tmp_path / "busy")] * 6)]
    assert [isinstance(result, int) for result in made] == [True] * 6
