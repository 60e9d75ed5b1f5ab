"""Choice of the baseline, the stride that all clips are aligned to: of a named clip, or the most typical one."""

from __future__ import annotations

from collections.abc import Mapping

from motionsplice.motion.errors import BaselineError, MotionError, did_you_mean
from motionsplice.precompute.alignment.baseline import no_stride
from motionsplice.precompute.alignment.typical import most_typical
from motionsplice.precompute.job.clip_work import StrideSearch, load_or_run
from motionsplice.precompute.job.entries import FoundStride
from motionsplice.precompute.job.readings import Clips

FEW = 3  # errors that a message about many clips lists


def named_stride(name: str, search: StrideSearch, clips: Clips, failed: Mapping[str, MotionError]) -> FoundStride:
    """Returns the stride of the named clip. Raises BaselineError if the clip is unknown or has no stride."""
    if name in failed:
        raise BaselineError(f"the baseline cannot be read: {failed[name]}")
    if name not in clips:
        mend = did_you_mean(name, [*clips, *failed])
        raise BaselineError(f"the baseline {name!r} is not among the clips", mend=mend)
    found = load_or_run(search, clips[name]).found()
    if found is None:
        raise no_stride(name)
    return found


def typical_stride(search: StrideSearch, walks: Clips, failed: Mapping[str, MotionError]) -> FoundStride:
    """Returns the most typical stride of all locomotions.

    Raises BaselineError if no locomotion has a stride, with the reasons why clips failed.
    """
    if failed and not walks:
        raise BaselineError("none of the locomotions can be read", mend=_reasons(failed))
    if not walks:
        problem = "all clips are actions or hands, so none can be the baseline"
        raise BaselineError(problem, mend="Add a plain walk of a few steps, or name a clip with --baseline")
    key = search.choice_key(walks)
    name = search.cache.load(key, lambda fields, _: str(fields["name"]) if fields["name"] in walks else None)
    if name is None:
        search.cache.read_ahead(search.key(walk) for walk in walks.values())
        rings = [ring for walk in walks.values() if (ring := load_or_run(search, walk).ring) is not None]
        if not rings:
            problem = "none of the clips can be the baseline, because none has a stride"
            raise BaselineError(problem, mend=_reasons(failed) or "Add a plain walk of a few steps")
        name = most_typical(rings).name
        search.cache.store(key, {"name": name}, {})
    return named_stride(name, search, walks, failed)


def _reasons(failed: Mapping[str, MotionError]) -> str:
    """Returns why clips failed: the first FEW errors, and how many more there are."""
    errors = [f"{name}: {str(failed[name]).rstrip('.')}." for name in sorted(failed)[:FEW]]
    return " ".join(errors) + (f" And {len(failed) - FEW} more failed." if len(failed) > FEW else "")
