"""Runs one function over many tasks: here, in a given number of processes, or in an executor that others opened."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Future
from contextlib import suppress
from itertools import islice
from queue import SimpleQueue
from typing import TypeVar

from motionsplice.motion.errors import MotionError

Task = TypeVar("Task")
Result = TypeVar("Result")
Outcomes = Generator[
    tuple[Task, Result | MotionError], None, None
]  # each task with its result or its error, as they finish


class WorkerDiedError(MotionError):
    """The process that worked on a clip died each time, for lack of memory or by a crash. Other clips finish."""

    def of(self, clip: str) -> WorkerDiedError:
        """Returns the same error with the name of the clip."""
        return WorkerDiedError(self.problem, place=f"clip {clip!r}", mend=self.mend)


def attempt(function: Callable[[Task], Result], task: Task) -> Result | MotionError:
    """Returns the result, or the error as a MotionError, even if it is a bug: one clip does not stop the others."""
    try:
        return function(task)
    except MotionError as error:
        return error
    except MemoryError:
        return MotionError("not enough memory", mend="Use fewer --jobs, or a shorter clip")
    except Exception as error:
        problem = f"unexpected {type(error).__name__}: {error}"
        return MotionError(problem, mend="This is a bug in motionsplice: please report it, with the file")


def one_after_another(function: Callable[[Task], Result], tasks: Iterable[Task]) -> Outcomes[Task, Result]:
    """Does the tasks in this process."""
    for task in tasks:
        yield task, attempt(function, task)


def finished(
    submit: Callable[[Task], Future[Result]], tasks: Iterable[Task], most: int
) -> Iterator[tuple[Task, Future[Result]]]:
    """Submits tasks, at most so many at a time, and yields each with its future when it is done.

    If the executor breaks, the tasks that were submitted are yielded, and the others stay in `tasks`, if it is an
    iterator. When the caller stops, tasks that have not begun are cancelled.
    """
    waiting, running, done = iter(tasks), dict[Future[Result], Task](), SimpleQueue[Future[Result]]()

    def start(count: int) -> None:
        for task in islice(waiting, count):
            future = _submitted(submit, task)
            running[future] = task
            future.add_done_callback(done.put)

    try:
        start(most)
        while running:
            future = done.get()
            yield running.pop(future), future
            if future.cancelled() or not isinstance(future.exception(), BrokenExecutor):
                start(1)
    finally:
        for future in running:
            with suppress(Exception):  # of an executor that is gone
                future.cancel()


def _submitted(submit: Callable[[Task], Future[Result]], task: Task) -> Future[Result]:
    try:
        return submit(task)
    except RuntimeError as error:  # broken, or shut down
        future = Future[Result]()
        future.set_exception(BrokenExecutor(str(error)))
        return future
