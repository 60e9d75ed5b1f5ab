"""Connections whose frames are made together, and those of them that catch up."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from motionsplice.service.characters.connection import Connection
from motionsplice.service.characters.ensemble import Ensemble
from motionsplice.service.characters.lateness import BEHIND, frames_at_once, moved


def together(group: list[Connection]) -> Ensemble:
    """Returns the scenes of a group as an ensemble: that of the frames before, if they are the same."""
    scenes, ensemble = [one.play.scene for one in group], group[0].ensemble
    if ensemble is None or not ensemble.holds(scenes):
        ensemble = Ensemble(scenes)
        for one in group:
            one.ensemble = ensemble
    return ensemble


def punctual_first(groups: list[list[Connection]], missed: Mapping[Connection, int]) -> Iterator[list[Connection]]:
    """Yields the groups, first of those that miss no frames, so that they do not wait for those that catch up."""
    for misses in (False, True):
        for group in groups:
            if some := [one for one in group if bool(missed[one]) is misses]:
                yield some


def alike(groups: list[list[Connection]], missed: Mapping[Connection, int]) -> list[list[Connection]]:
    """Returns the groups of those that miss as many frames as the first."""
    found = ([one for one in group if missed[one] == missed[groups[0][0]]] for group in groups)
    return [group for group in found if group]


def catch_up(group: list[Connection], missed: Mapping[Connection, int], work: int, most: float) -> tuple[int, bool]:
    """Leaves out the frames that connections of a group miss.

    Args:
        group: The connections.
        missed: How many frames each misses.
        work: Characters times frames that all miss.
        most: Frames by which characters move on, if many more are missed.

    Returns:
        How many frames were left out, and whether these are all that were missed.
    """
    by_count: dict[int, list[Connection]] = {}
    for one in group:
        if missed[one]:
            by_count.setdefault(missed[one], []).append(one)
    skipped, is_whole = 0, True
    for count, some in by_count.items():
        play = some[0].play
        frames = moved(count, play.rate)
        if frames - most > BEHIND * play.rate:  # or those that are left would be made, as they are not much too late
            count, frames, is_whole = count - frames + int(most), int(most), False
        if len(play.scene):
            for later, row, event in together(some).leave_out(frames, frames_at_once(work, play.rate)):
                some[row].queue_event(frame=some[row].play.frame + count - frames + later, **event)
        for one in some:
            one.play = one.play.after(count)
        skipped += count * len(some)
    return skipped, is_whole
