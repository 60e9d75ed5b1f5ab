"""Running one function over many tasks, in as many processes as asked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from typing import TypeVar

from motion.errors import MotionError

Task = TypeVar("Task")
Result = TypeVar("Result")


@contextmanager
def workers(count: int) -> Iterator[Executor | None]:
    """A pool of `count` processes; None for one, which needs no pool."""
    if count <= 1:
        yield None
        return
    # Forked children of a process with threads (a progress bar's, BLAS's) may hang, so they are spawned.
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        yield pool


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
