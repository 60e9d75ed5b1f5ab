"""Which clip's stride all others are aligned to: the one that is named, or the most typical of all."""

from __future__ import annotations

from collections.abc import Mapping

from motionsplice.motion.errors import BaselineError, MotionError, did_you_mean
from motionsplice.precompute.alignment.baseline import most_typical, no_stride
from motionsplice.precompute.job.clip_work import Clips, StrideSearch, kept
from motionsplice.precompute.job.entries import FoundStride

FEW = 3  # errors that a message about many clips quotes


def named_stride(name: str, search: StrideSearch, clips: Clips, failed: Mapping[str, MotionError]) -> FoundStride:
    """The stride of the clip of this name. Raises BaselineError if there is no such clip, or no stride in it."""
    if name in failed:
        raise BaselineError(f"the baseline cannot be read: {failed[name]}")
    if name not in clips:
        mend = did_you_mean(name, [*clips, *failed])
        raise BaselineError(f"the baseline {name!r} is not among the clips", mend=mend)
    found = kept(search, clips[name]).found()
    if found is None:
        raise no_stride(name)
    return found


def typical_stride(search: StrideSearch, walks: Clips, failed: Mapping[str, MotionError]) -> FoundStride:
    """The stride of the one among the locomotions that is most typical of all.

    Raises BaselineError if none has a stride, with the reasons why others failed.
    """
    if failed and not walks:
        raise BaselineError("not one of the locomotions can be read", mend=_reasons(failed))
    if not walks:
        problem = "all clips are actions or hands, and none can serve as the baseline"
        raise BaselineError(problem, mend="Add a plain walk of a few steps, or name a clip as --baseline")
    searched = [kept(search, one).found() for one in walks.values()]
    strides = {found.ring.name: found for found in searched if found is not None}
    if not strides:
        problem = "none of the clips can serve as the baseline, for none of them has a stride"
        raise BaselineError(problem, mend=_reasons(failed) or "Add a plain walk of a few steps")
    key = search.choice_key(walks)
    chosen = search.cache.load(key, lambda said, _: strides[said["name"]])
    if chosen is None:
        chosen = strides[most_typical([found.ring for found in strides.values()]).name]
        search.cache.store(key, {"name": chosen.ring.name}, {})
    return chosen


def _reasons(failed: Mapping[str, MotionError]) -> str:
    """Why clips failed: the first FEW of them, and how many more."""
    told = [f"{name}: {str(failed[name]).rstrip('.')}." for name in sorted(failed)[:FEW]]
    return " ".join(told) + (f" And {len(failed) - FEW} more failed." if len(failed) > FEW else "")
