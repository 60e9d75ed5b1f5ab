"""The offline job: files of clips -> a bank. What was worked out before is not worked out again (docs/offline.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

from motionsplice.motion.clip_settings import DEFAULT_SETTINGS, ClipSettings
from motionsplice.motion.errors import BankError, BaselineError, MotionError, SettingsError, did_you_mean
from motionsplice.precompute.alignment.baseline import Baseline
from motionsplice.precompute.hands.settings import HandsOnBody
from motionsplice.precompute.job.bank_builder import write_bank
from motionsplice.precompute.job.baseline_choice import named_stride, typical_stride
from motionsplice.precompute.job.cache import Cache
from motionsplice.precompute.job.clip_work import (
    Clips,
    Identified,
    Preparation,
    StrideSearch,
    Work,
    identify,
    load_or_run,
)
from motionsplice.precompute.job.hand_work import (
    HandsLaying,
    HandsReading,
    HandsTask,
    all_hands,
    recipe_of,
    tasks_of,
    with_fingers,
)
from motionsplice.precompute.job.sources import find_sources
from motionsplice.precompute.job.workers import outcomes, workers
from motionsplice.precompute.preparation.neutral import nearest_gait
from motionsplice.precompute.preparation.prepared import PreparedClip
from motionsplice.runtime.bank import Bank

Progress = Callable[[str, int, int], None]  # what is being done, how many are done, of how many
Failures = dict[str, MotionError]
Task = TypeVar("Task", Identified, HandsTask)
CACHE = "cache"  # a folder in the bank's
WORTH_A_PROCESS = 24_000_000  # bytes of clips: fewer are read and aligned in the time in which a process starts


@dataclass(frozen=True)
class Outcome:
    """What the job made: the bank's digest, its baseline and clips, and why the others failed.

    kept: how many of the clips an earlier run had aligned. unchanged: the bank was there already, just so.
    """

    digest: str
    baseline: Baseline
    clips: tuple[str, ...]
    failed: Mapping[str, MotionError]
    kept: int
    unchanged: bool


def build_bank(
    paths: Iterable[Path],
    out: Path,
    *,
    baseline: str | None = None,
    roles: Mapping[str, str | Sequence[str]] | None = None,
    hands: Sequence[HandsOnBody] = (),
    settings: ClipSettings = DEFAULT_SETTINGS,
    jobs: int = 1,
    progress: Progress = lambda stage, done, total: None,
) -> Outcome:
    """Reads clips, aligns each to the baseline and writes the bank `out`.

    `paths` are motion files or folders of them; a `clips.toml` beside a file says more about it, and `settings` are for
    files of which it says nothing. `hands`, and a `hands.toml` beside a file, say which clips are hands, laid on which
    others; these are no clips of the bank themselves. Without `baseline`, it is the locomotion whose stride is the most
    typical. `jobs` is how many processes may work at once. Clips that fail are left out and reported. All that is
    worked out is kept below `out`, so that the next run, or one after this was killed, works only on what is new.

    Raises MotionError if there is nothing to read, the baseline is unusable, two clips have one name, or hands or their
    body are not there.
    """
    clips: Clips = {}
    failed: Failures = {}
    sources = find_sources(paths, roles or {}, settings)
    for source in sources:
        try:
            clips[source.name] = identify(source)
        except MotionError as error:
            failed[source.name] = error
    laying = all_hands(hands, sources)
    worn = {name: clips.pop(name) for name in sorted({one.hands for one in laying}) if name in clips}
    cache = Cache(out / CACHE)
    do = partial(_do, failed=failed, jobs=jobs, progress=progress)
    search = StrideSearch(cache)
    asked = {name: one for name, one in clips.items() if _may_be_baseline(one, baseline)}
    do("reading", search, asked)
    walks = {name: one for name, one in asked.items() if name not in failed}
    if baseline is None:
        stride = typical_stride(search, walks, failed)
    else:
        stride = named_stride(baseline, search, clips, failed)
    readings = HandsReading(cache)
    do("hands", readings, worn)
    worn = {name: one for name, one in worn.items() if name not in failed}
    work = Preparation.of(cache, with_fingers(stride, readings, worn))
    new = do("aligning", work, {name: one for name, one in clips.items() if name not in failed})
    _fail_without_neutral(clips, failed)
    if work.ring.name in failed:
        raise BaselineError(f"the baseline cannot be used: {failed[work.ring.name]}")
    aligned = {name: one for name, one in clips.items() if name not in failed}
    laid, tasks = HandsLaying(work, readings), tasks_of(laying, aligned, worn)
    do("laying", laid, tasks)
    tasks = {label: task for label, task in tasks.items() if label not in failed}
    recipe = work.recipe(aligned, recipe_of(laid, tasks))
    digest = cache.load(recipe, lambda said, _: str(said["bank"]))
    unchanged = digest is not None and _holds_bank(out, digest)
    if digest is None or not unchanged:
        prepared = {name: load_or_run(work, one) for name, one in aligned.items()}
        _choose_neutrals(prepared, work.ring.name)
        digest = write_bank(
            out,
            work.rig.skeleton,
            work.rig.roles,
            work.ring,
            list(prepared.values()),
            [load_or_run(laid, task) for task in tasks.values()],
        )
        cache.store(recipe, {"bank": digest}, {})
    used = {one_work.key(one) for one_work in (search, work) for one in clips.values()}
    used |= {readings.key(one) for one in worn.values()} | {laid.key(task) for task in tasks.values()}
    cache.keep_only({recipe, search.choice_key(walks), *used})
    return Outcome(
        digest, work.ring, tuple(aligned), dict(sorted(failed.items())), len(aligned.keys() - new), unchanged
    )


def _do(
    stage: str,
    work: Work[Task, object],
    tasks: Mapping[str, Task],
    *,
    failed: Failures,
    jobs: int,
    progress: Progress,
) -> set[str]:
    """Does the work on those tasks of which the cache holds no result, and returns their names."""
    new = {name: one for name, one in tasks.items() if not work.cache.holds(work.key(one))}
    names, size = {id(one): name for name, one in new.items()}, sum(one.size for one in new.values())
    with workers(min(jobs, len(new), size // WORTH_A_PROCESS)) as pool:
        for done, (one, result) in enumerate(outcomes(pool, work.run, new.values()), 1):
            if isinstance(result, MotionError):
                failed[names[id(one)]] = result
            progress(stage, done, len(new))
    return set(new)


def _may_be_baseline(one: Identified, named: str | None) -> bool:
    return one.source.settings.kind == "locomotion" if named is None else one.source.name == named


def _fail_without_neutral(clips: Clips, failed: Failures) -> None:
    """Clips whose neutral is not there fail, and so do those whose neutral then is not."""
    neutrals = {name: one.source.settings.neutral for name, one in clips.items() if name not in failed}
    while astray := {name: neutral for name, neutral in neutrals.items() if neutral and neutral not in neutrals}:
        for name, neutral in astray.items():
            problem = f"its neutral {neutral!r} is not in the bank"
            failed[name] = SettingsError(problem, place=f"clip {name!r}", mend=did_you_mean(neutral, neutrals))
            del neutrals[name]


def _choose_neutrals(prepared: dict[str, PreparedClip], baseline: str) -> None:
    """As named; else a locomotion is its own, and an action has the locomotion nearest in gait, or the baseline."""
    locomotions = {name: one for name, one in prepared.items() if one.kind == "locomotion"}
    candidates = locomotions or {baseline: prepared[baseline]}
    for name, one in prepared.items():
        if not one.neutral:
            neutral = name if one.kind == "locomotion" else nearest_gait(one, candidates)
            prepared[name] = replace(one, neutral=neutral)


def _holds_bank(path: Path, digest: str) -> bool:
    """Whether the folder holds the bank of this digest, whole and sound."""
    try:
        return Bank.open(path).digest == digest
    except BankError:
        return False
