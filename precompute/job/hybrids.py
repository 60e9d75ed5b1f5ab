"""Hybrid actions, which stand for a while and walk for a while: each stretch is a clip of the bank too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, replace
from typing import Any

from motionsplice.motion.errors import ClipError, MotionError
from motionsplice.motion.retarget.rig import Rig
from motionsplice.precompute.hands.rows import LaidHands, hands_on_stretch
from motionsplice.precompute.job.cache import key_of
from motionsplice.precompute.job.clip_work import Preparation, load_or_run
from motionsplice.precompute.job.readings import Clips, Identified
from motionsplice.precompute.preparation.cuts import Cut, cuts
from motionsplice.precompute.preparation.prepared import PreparedClip
from motionsplice.runtime.format.rows import Layout

Hybrids = dict[str, Clips]  # the stretches of each hybrid action, by its name


def cuts_key(preparation: Preparation, clips: Clips) -> str:
    """Returns the key of what `hybrids_among` stores for these clips."""
    return key_of("cuts", [(name, preparation.key(one)) for name, one in _actions(clips).items()])


def hybrids_among(preparation: Preparation, clips: Clips, failed: dict[str, MotionError]) -> Hybrids:
    """Returns the hybrids among prepared clips. Fails those whose stretches would be named as other clips are."""
    actions, key = _actions(clips), cuts_key(preparation, clips)
    found = preparation.cache.load(key, lambda fields, _: _unpacked(fields["cuts"]))
    if found is None:
        preparation.cache.read_ahead(preparation.key(one) for one in actions.values())
        found = {name: cut for name, one in actions.items() if (cut := _cuts(load_or_run(preparation, one)))}
        preparation.cache.store(key, {"cuts": {name: [astuple(one) for one in cut] for name, cut in found.items()}}, {})
    hybrids = {name: _stretches(clips[name], cut) for name, cut in found.items()}
    for name, stretches in list(hybrids.items()):
        if taken := sorted(stretches.keys() & clips.keys()):
            problem = f"it stands and walks by turns, and its stretch {taken[0]!r} has the name of another clip"
            place, mend = f"clip {name!r}", "Rename one of them"
            failed[name] = ClipError(problem, file=clips[name].files, place=place, mend=mend)
            del hybrids[name]
    return hybrids


def fail_whole(hybrids: Hybrids, failed: dict[str, MotionError]) -> None:
    """Fails hybrids of which a stretch has failed, with all their stretches."""
    for name, stretches in hybrids.items():
        if reasons := [failed[one] for one in stretches if one in failed]:
            failed |= dict.fromkeys((name, *stretches), reasons[0])


def hands_on_stretches(hands: Sequence[LaidHands], clips: Mapping[str, PreparedClip], rig: Rig) -> list[LaidHands]:
    """Returns hands on hybrids as hands on each of their stretches."""
    layout = Layout.of(rig.skeleton, rig.roles)
    return [hands_on_stretch(laid, clips[name], layout, rig) for laid in hands for name in clips[laid.body].stretches]


def _actions(clips: Clips) -> Clips:
    return {name: one for name, one in clips.items() if one.source.settings.kind == "action"}


def _cuts(one: PreparedClip) -> tuple[Cut, ...]:
    return cuts(one.alignment.stretches, one.rate, one.frame_count)


def _stretches(one: Identified, cut: tuple[Cut, ...]) -> Clips:
    sources = [replace(one.source, name=f"{one.source.name}~{each.number}", cut=each) for each in cut]
    return {source.name: replace(one, source=source) for source in sources}


def _unpacked(fields: Mapping[str, Sequence[Sequence[Any]]]) -> dict[str, tuple[Cut, ...]]:
    return {name: tuple(Cut(*one) for one in cut) for name, cut in fields.items()}
