"""Work in processes of this machine. A process that dies is the failure of its task, not of the job."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from itertools import chain
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.process import BaseProcess
from threading import Thread
from types import ModuleType

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.job.workers import Outcomes, Result, Task, WorkerDiedError, attempt, finished

ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")}


def in_processes(count: int, function: Callable[[Task], Result], tasks: Iterable[Task]) -> Outcomes[Task, Result]:
    """Does the tasks in `count` processes.

    If one dies, those that may have killed it are done one by one, and the others in new processes. If none of them
    dies by itself, they did not fit into memory together: then half as many processes go on.
    """
    waiting = iter(tasks)
    while True:
        lost: list[Task] = []
        with _pool(count) as pool:
            for task, future in finished(partial(_submit, pool, function), waiting, 2 * count):
                try:
                    yield task, future.result()
                except BrokenExecutor:
                    lost.append(task)
        if not lost:
            return
        died = False
        for task, result in _one_by_one(function, lost):
            died = died or isinstance(result, WorkerDiedError)
            yield task, result
        if not died:
            count = max(1, count // 2)


def _one_by_one(function: Callable[[Task], Result], tasks: Iterable[Task]) -> Outcomes[Task, Result]:
    """Does the tasks in one process, and those after one that kills it in another."""
    waiting = iter(tasks)
    for first in waiting:
        killer: Task | None = None
        with _pool(1) as pool:
            others, process = set(active_children()), None
            for task in chain([first], waiting):
                future = _submit(pool, function, task)
                process = process or next(iter(set(active_children()) - others), None)
                try:
                    yield task, future.result()
                except BrokenExecutor:
                    killer = task
                    break
        if killer is not None:  # the pool has ended by now, so it is known how the process did
            yield killer, _death(process)


def _death(process: BaseProcess | None) -> MotionError:
    """Returns the error for a clip whose process died twice."""
    status = None if process is None else process.exitcode
    if status == -signal.SIGKILL:
        problem = "its worker process was killed (SIGKILL), also when it worked alone; probably memory ran out"
        return WorkerDiedError(problem, mend="Cut the clip into shorter ones, or use a machine with more memory")
    if status is not None and status < 0:
        how = f"crashed with {signal.Signals(-status).name}"
    else:
        how = f"ended with status {status}"
    mend = "This is a bug in motionsplice or a library: please report it, with the file"
    return WorkerDiedError(f"its worker process {how}, also when it worked alone", mend=mend)


@contextmanager
def _pool(count: int) -> Iterator[ProcessPoolExecutor]:
    # Children are spawned: forked from a process with threads (a progress bar's, BLAS's), they may hang.
    with ProcessPoolExecutor(count, get_context("spawn"), end_with_parent) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(cancel_futures=True)  # or an interrupt would wait for all tasks
            raise


def _submit(pool: ProcessPoolExecutor, function: Callable[[Task], Result], task: Task) -> Future[Result | MotionError]:
    with _nothing_inherited():  # submitting a task may start a process
        return pool.submit(attempt, function, task)


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
