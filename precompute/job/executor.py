"""Work in an executor that others opened, on this machine or on a cluster (docs/cluster.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, CancelledError, Executor
from functools import partial

from motionsplice.motion.errors import MotionError
from motionsplice.precompute.job.method import version_of_method
from motionsplice.precompute.job.workers import Outcomes, Result, Task, WorkerDiedError, attempt, finished

AHEAD = 1000  # tasks that are submitted at a time: enough for hundreds of workers, and few to keep in memory
KILLED = "KilledWorker"  # Dask's exception for a task whose workers died, which cannot be imported without Dask


class ExecutorError(MotionError):
    """The executor or its cluster cannot do the work. It is no fault of a clip, so the whole job fails."""


def in_executor(
    executor: Executor, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Outcomes[Task, Result]:
    """Does the tasks in an executor, which stays open. Raises ExecutorError if it breaks or cannot run them."""
    submit = partial(executor.submit, partial(_attempt_of, version_of_method(), function))
    for task, future in finished(submit, tasks, AHEAD):
        try:
            result = future.result()
        except (BrokenExecutor, CancelledError) as error:
            mend = "Start it again: what is done is in the cache"
            raise ExecutorError(f"the executor was closed or lost ({type(error).__name__})", mend=mend) from None
        except Exception as error:
            if type(error).__name__ != KILLED:
                mend = "Install the same versions of motionsplice and its libraries on every worker"
                problem = f"the workers cannot do the work: {type(error).__name__}: {error}"
                raise ExecutorError(problem, mend=mend) from None
            mend = "See the workers' logs: probably memory ran out. Give workers more memory, or cut the clip"
            yield task, WorkerDiedError("every worker that tried it died", mend=mend)
        else:
            if isinstance(result, ExecutorError):
                raise result
            yield task, result


def _attempt_of(version: str, function: Callable[[Task], Result], task: Task) -> Result | MotionError:
    """Attempts a task in a worker, if this has the same version of the method: others may make other bytes."""
    if version_of_method() != version:
        problem = "a worker has another version of motionsplice, NumPy, SciPy or Numba"
        return ExecutorError(problem, mend="Install the same versions on every worker")
    return attempt(function, task)
