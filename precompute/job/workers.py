"""Running one function over many tasks, in as many processes as asked."""

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
    """A pool of `count` processes; None for one, which needs no pool."""
    if count <= 1:
        yield None
        return
    # Forked children of a process with threads (a progress bar's, BLAS's) may hang, so they are spawned.
    with ProcessPoolExecutor(count, get_context("spawn"), end_with_parent) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(cancel_futures=True)  # else an interrupt would wait for all tasks
            raise


def outcomes(
    pool: Executor | None, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Iterator[tuple[Task, Result | MotionError]]:
    """Each task with what `function` made of it, or the error that it raised as a MotionError, as they are done.

    So one bad task leaves the others alone, even if the error is our own. Raises MotionError if a process died.
    """
    if pool is None:
        for task in tasks:
            yield task, _attempt(function, task)
        return
    with _nothing_inherited():  # processes start as tasks come in
        running = {pool.submit(_attempt, function, task): task for task in tasks}
    try:
        for one in as_completed(running):
            yield running[one], one.result()
    except BrokenProcessPool:
        raise MotionError("a worker process died, perhaps for lack of memory", mend="Use fewer --jobs") from None


def _attempt(function: Callable[[Task], Result], task: Task) -> Result | MotionError:
    try:
        return function(task)
    except MotionError as error:
        return error
    except MemoryError:
        return MotionError("there is not enough memory for it", mend="Use fewer --jobs, or a shorter clip")
    except Exception as error:
        problem = f"an unexpected {type(error).__name__}: {error}"
        return MotionError(problem, mend="This is a bug in motionsplice: please report it, with the file")


def end_with_parent() -> None:
    """A worker whose parent was killed would wait for its next task forever."""
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    Thread(target=watch, daemon=True).start()


@contextmanager
def _nothing_inherited() -> Iterator[None]:
    """Processes that are spawned meanwhile import what their tasks need and not the program that asked for them.

    The command line's imports, which draw pictures and serve, would take each of them a second, and a script without
    `if __name__ == "__main__"` would start itself again. Each has one core, so BLAS has one thread.
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
