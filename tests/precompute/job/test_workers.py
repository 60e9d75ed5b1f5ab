from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.job.workers import outcomes, workers


def task(number: int) -> int:
    if number == 0:
        raise KeyboardInterrupt
    if number == 1:
        raise MemoryError
    if number == 2:
        raise ValueError("two")
    return number


@pytest.mark.parametrize("processes", [1, 2])
def test_an_unexpected_error_fails_one_task_and_the_others_finish(processes: int) -> None:
    with workers(processes) as pool:
        made = dict(outcomes(pool, task, [1, 2, 3, 4]))
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
    with workers(2) as pool:
        assert [made for _, made in outcomes(pool, of_a_program, [1, 2])] == [[], []]


def threads(number: int) -> str:
    return os.environ["OPENBLAS_NUM_THREADS"]


def test_a_worker_has_one_thread_and_our_environment_stays_unchanged() -> None:
    before = dict(os.environ)
    with workers(2) as pool:
        assert [made for _, made in outcomes(pool, threads, [1, 2])] == ["1", "1"]
    assert dict(os.environ) == before


KILLED = """
import os, signal, time
from motionsplice.precompute.job.workers import outcomes, workers

with workers(2) as pool:
    for _, number in outcomes(pool, os.getpgid, [0] * 2):
        print(*pool._processes, flush=True)
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
    with workers(1) as pool, pytest.raises(KeyboardInterrupt):
        list(outcomes(pool, task, [0, 3]))
