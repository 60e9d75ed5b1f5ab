"""The offline job: files of clips -> a bank."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

from motion.errors import BaselineError, MotionError, SettingsError, did_you_mean
from motion.formats.files import Reading, read_clip
from motion.roles import Roles
from motion.skeleton import Skeleton
from precompute.bank_builder import write_bank
from precompute.baseline import Baseline, find_baseline, most_typical
from precompute.clip_settings import DEFAULT_SETTINGS, ClipSettings
from precompute.neutral import nearest_gait
from precompute.prepared import PreparedClip, prepare
from precompute.sources import Source, find_sources
from precompute.workers import outcomes, workers
from runtime.manifest import content_digest

Progress = Callable[[str, int, int], None]  # what is being done, how many are done, of how many
Failures = dict[str, MotionError]
Made = TypeVar("Made")
FEW = 3  # errors that a message about many clips quotes


@dataclass(frozen=True)
class Loaded:
    """One clip file, read: the digest of its bytes, and the clip's own stride if it has one."""

    source: Source
    digest: str
    reading: Reading
    stride: Baseline | None


@dataclass(frozen=True)
class Outcome:
    """What the job made: the bank's digest, its baseline and clips, and why the others failed."""

    digest: str
    baseline: Baseline
    clips: tuple[str, ...]
    failed: Mapping[str, MotionError]


def precompute(
    paths: Iterable[Path],
    out: Path,
    *,
    baseline: str | None = None,
    roles: Mapping[str, str | Sequence[str]] | None = None,
    settings: ClipSettings = DEFAULT_SETTINGS,
    jobs: int = 1,
    progress: Progress = lambda stage, done, total: None,
) -> Outcome:
    """Reads clips, aligns each to the baseline and writes the bank `out`.

    `paths` are motion files or folders of them; a `clips.toml` beside a file says more about it, and `settings` are for
    files of which it says nothing. Without `baseline`, it is the locomotion whose stride is the most typical. More than
    one of `jobs` are processes of their own, which a script must start under `if __name__ == "__main__"`. Clips that
    fail are left out and reported. Raises MotionError if there is nothing to do, the baseline is unusable, or two clips
    have one name.
    """
    sources = find_sources(paths, roles or {}, settings)
    failed: Failures = {}
    loaded: dict[str, Loaded] = {}
    prepared: dict[str, PreparedClip] = {}
    with workers(min(jobs, len(sources))) as pool:
        for done, (source, result) in enumerate(
            outcomes(pool, partial(load, find_stride=baseline is None), sources), 1
        ):
            _sort(source.name, result, loaded, failed)
            progress("reading", done, len(sources))
        ring = choose_baseline(loaded, failed, baseline)
        rig = loaded[ring.name].reading
        align_one = partial(_prepare, skeleton=rig.clip.skeleton, roles=rig.roles, baseline=ring)
        for done, (one, ready) in enumerate(outcomes(pool, align_one, list(loaded.values())), 1):
            _sort(one.source.name, ready, prepared, failed)
            progress("aligning", done, len(loaded))
    _settle_neutrals(prepared, failed, rig.roles, ring.name)
    digest = write_bank(out, rig.clip.skeleton, rig.roles, ring, list(prepared.values()))
    return Outcome(digest, ring, tuple(sorted(prepared)), dict(sorted(failed.items())))


def load(source: Source, find_stride: bool) -> Loaded:
    """Reads one clip file and, if asked and it is a locomotion, looks for a stride in it. Raises MotionError."""
    settings, stride = source.settings, None
    reading = read_clip(source.file, skip_frames=settings.skip_frames, unit=settings.unit, roles=source.roles)
    if find_stride and settings.kind == "locomotion":
        with suppress(BaselineError):  # only one clip needs to serve as the baseline
            stride = find_baseline(reading.clip, reading.roles)
    return Loaded(source, content_digest(source.file.read_bytes()), reading, stride)


def choose_baseline(loaded: Mapping[str, Loaded], failed: Mapping[str, MotionError], name: str | None) -> Baseline:
    """The named clip's stride, or the most typical of all locomotions' strides. Raises BaselineError."""
    if not loaded:
        raise BaselineError("not one of the clips can be read", mend=_reasons(failed))
    if name is None:
        strides = [one.stride for one in loaded.values() if one.stride is not None]
        if not strides:
            problem = "none of the clips can serve as the baseline, for none of them has a stride"
            raise BaselineError(problem, mend=_reasons(failed) or "Add a plain walk of a few steps")
        return most_typical(strides)
    if name in failed:
        raise BaselineError(f"the baseline cannot be read: {failed[name]}")
    if name not in loaded:
        raise BaselineError(f"the baseline {name!r} is not among the clips", mend=did_you_mean(name, loaded))
    return find_baseline(loaded[name].reading.clip, loaded[name].reading.roles)


def _reasons(failed: Mapping[str, MotionError]) -> str:
    """Why clips failed: the first FEW of them, and how many more."""
    told = [f"{name}: {str(failed[name]).rstrip('.')}." for name in sorted(failed)[:FEW]]
    return " ".join(told) + (f" And {len(failed) - FEW} more failed." if len(failed) > FEW else "")


def _prepare(one: Loaded, skeleton: Skeleton, roles: Roles, baseline: Baseline) -> PreparedClip:
    settings = one.source.settings
    return replace(
        prepare(one.reading.clip, one.reading.roles, skeleton, roles, baseline),
        kind=settings.kind,
        neutral=settings.neutral or "",
        tags=settings.tags,
        notes=one.reading.notes,
        file_warnings=one.reading.warnings,
        source=one.digest,
    )


def _settle_neutrals(prepared: dict[str, PreparedClip], failed: Failures, roles: Roles, baseline: str) -> None:
    """As named; else a locomotion is its own, and an action has the locomotion nearest in gait, the baseline at last.

    Clips whose neutral is not there fail. Raises BaselineError if the baseline is one of them.
    """
    while astray := [one for one in prepared.values() if one.neutral and one.neutral not in prepared]:
        for one in astray:
            name, problem = one.clip.name, f"its neutral {one.neutral!r} is not in the bank"
            failed[name] = SettingsError(problem, place=f"clip {name!r}", mend=did_you_mean(one.neutral, prepared))
            del prepared[name]
    if baseline not in prepared:
        raise BaselineError(f"the baseline cannot be used: {failed[baseline]}")
    locomotions = {name: one for name, one in prepared.items() if one.kind == "locomotion"}
    candidates = locomotions or {baseline: prepared[baseline]}
    for name, one in prepared.items():
        if not one.neutral:
            neutral = name if one.kind == "locomotion" else nearest_gait(one, candidates, roles)
            prepared[name] = replace(one, neutral=neutral)


def _sort(name: str, result: Made | MotionError, sound: dict[str, Made], failed: Failures) -> None:
    if isinstance(result, MotionError):
        failed[name] = result
    else:
        sound[name] = result
