"""Runs one function over many tasks, in a given number of processes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from threading import Thread
from types import ModuleType
from typing import TypeVar

from motionsplice.motion.errors import MotionError

Task = TypeVar("Task")
Result = TypeVar("Result")

ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")}


@contextmanager
def workers(count: int) -> Iterator[Executor | None]:
    """Opens a pool of `count` processes; None if `count` is 1 or less, which needs no pool."""
    if count <= 1:
        yield None
        return
    # Children are spawned: forked from a process with threads (a progress bar's, BLAS's), they may hang.
    with ProcessPoolExecutor(count, get_context("spawn"), end_with_parent) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(cancel_futures=True)  # or an interrupt would wait for all tasks
            raise


def outcomes(
    pool: Executor | None, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Iterator[tuple[Task, Result | MotionError]]:
    """Yields each task with its result, or with its error as a MotionError, in the order in which they finish.

    A task that fails does not stop the others, even if the error is a bug. Raises MotionError if a process died.
    """
    if pool is None:
        for task in tasks:
            yield task, _attempt(function, task)
        return
    with _nothing_inherited():  # submitting tasks starts the processes
        running = {pool.submit(_attempt, function, task): task for task in tasks}
    try:
        for future in as_completed(running):
            yield running[future], future.result()
    except BrokenProcessPool:
        raise MotionError("a worker process died, probably out of memory", mend="Use fewer --jobs") from None


def _attempt(function: Callable[[Task], Result], task: Task) -> Result | MotionError:
    try:
        return function(task)
    except MotionError as error:
        return error
    except MemoryError:
        return MotionError("not enough memory", mend="Use fewer --jobs, or a shorter clip")
    except Exception as error:
        problem = f"unexpected {type(error).__name__}: {error}"
        return MotionError(problem, mend="This is a bug in motionsplice: please report it, with the file")


def end_with_parent() -> None:
    """Ends this worker when its parent ends. Without this, a worker whose parent was killed would wait forever."""
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    Thread(target=watch, daemon=True).start()


@contextmanager
def _nothing_inherited() -> Iterator[None]:
    """Makes processes spawned meanwhile import only what their tasks need, not the program that started them.

    The imports of the command line (plotting, service) would cost each process a second, and a script without
    `if __name__ == "__main__"` would run again in each. BLAS gets one thread, since each process has one core.
    """
    program, environment = sys.modules["__main__"], dict(os.environ)
    sys.modules["__main__"] = ModuleType("__main__")
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        sys.modules["__main__"] = program
        for name in ONE_THREAD.keys() - environment.keys():
            del os.environ[name]
        os.environ.update(environment)
