"""The offline job: motion files -> a bank. Nothing that has not changed is done again (docs/offline.md)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import TypeVar

from motionsplice.motion.clip_settings import DEFAULT_SETTINGS, ClipSettings
from motionsplice.motion.errors import BaselineError, MotionError
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.storage.place import Place, place_of, read_ahead
from motionsplice.motion.storage.remote import Remote, StorageError
from motionsplice.precompute.hands.settings import HandsOnBody
from motionsplice.precompute.job.bank_builder import write_bank
from motionsplice.precompute.job.bank_clips import BankClips
from motionsplice.precompute.job.baseline_choice import named_stride, typical_stride
from motionsplice.precompute.job.cache import CacheError
from motionsplice.precompute.job.clip_work import Preparation, StrideSearch, Work, load_or_run
from motionsplice.precompute.job.destination import Destination, destination
from motionsplice.precompute.job.entries import FoundStride
from motionsplice.precompute.job.executor import in_executor
from motionsplice.precompute.job.hand_work import (
    HandsLaying,
    HandsReading,
    HandsTask,
    all_hands,
    recipe_of,
    tasks_of,
    with_fingers,
)
from motionsplice.precompute.job.hybrids import Hybrids, cuts_key, fail_whole, hands_on_stretches, hybrids_among
from motionsplice.precompute.job.neutrals import fail_without_neutral, labels_of
from motionsplice.precompute.job.outcome import Outcome, Progress
from motionsplice.precompute.job.processes import in_processes
from motionsplice.precompute.job.readings import Clips, Contents, Identified, Readings, contents_of, identify
from motionsplice.precompute.job.skeleton import StrideOnSkeleton, rig_of
from motionsplice.precompute.job.sources import find_sources
from motionsplice.precompute.job.standing import fail_with_missing_limbs
from motionsplice.precompute.job.workers import Outcomes, WorkerDiedError, one_after_another

Task = TypeVar("Task", Identified, HandsTask)
WORTH_A_PROCESS = 24_000_000  # bytes of clips: fewer are read and aligned in the time in which a process starts


def build_bank(
    paths: Iterable[str | PathLike[str] | Remote],
    out: str | PathLike[str] | Remote,
    *,
    baseline: str | None = None,
    roles: Mapping[str, str | Sequence[str]] | None = None,
    hands: Sequence[HandsOnBody] = (),
    settings: ClipSettings = DEFAULT_SETTINGS,
    skeleton: str | PathLike[str] | Remote | None = None,
    retarget: bool = True,
    jobs: int = 1,
    executor: Executor | None = None,
    progress: Progress = lambda stage, done, total: None,
) -> Outcome:
    """Reads clips, aligns each to the baseline and writes a bank.

    A clip that fails is left out and reported. Results are cached below `out`, so the next run, also one after this
    was killed, works only on what is new.

    Args:
        paths: Motion files, or folders of them, on this machine or at URLs, such as `s3://bucket/clips`. A `clips.toml`
            beside a file has its settings, and a `hands.toml` the hands that are laid on bodies.
        out: Folder of the bank, or its URL.
        baseline: Name of the clip whose stride all others are aligned to; None takes the locomotion with the most
            typical stride.
        roles: Joints by role, for rigs whose names do not show them.
        hands: Hands to lay on bodies. A hands clip is not itself a clip of the bank.
        settings: What holds for a clip where its `clips.toml` says nothing else.
        skeleton: A motion file, a character or the folder of a bank, whose rig the bank gets. None for the baseline's.
        retarget: Whether clips of rigs with other joints or bind poses are retargeted. If not, they fail.
        jobs: Processes that may work at once on this machine.
        executor: Does the work instead, if given, and stays open: Dask's `client.get_executor(pure=False)`, or any
            other whose workers see the clips and the bank's folder by the same paths.
        progress: Called with the stage, how many of its clips are done, and how many there are.

    Returns:
        What was built, and which clips failed.

    Raises:
        MotionError: If there is nothing to read, the baseline is unusable, two clips have one name, hands or their
            body are missing, or the executor is lost.
    """
    if isinstance(paths, str | PathLike | Remote):
        paths = [paths]
    files = [place_of(path) for path in paths]
    rig = None if skeleton is None else place_of(skeleton)
    return Job(
        files, place_of(out), baseline, roles or {}, hands, settings, rig, retarget, jobs, executor, progress
    ).run()


@dataclass(eq=False)
class Job:
    """One run of the offline job: a method for each stage, in the order in which `run` calls them.

    clips and hand_clips are by name, in order of name; failed has the errors of those that drop out. hybrids: the
    stretches of each hybrid action, which are among the clips too. rig: the skeleton of the user's choice.
    """

    paths: Iterable[Path | Remote]
    out: Path | Remote
    baseline: str | None
    roles: Mapping[str, str | Sequence[str]]
    hands: Sequence[HandsOnBody]
    settings: ClipSettings
    skeleton: Path | Remote | None
    retarget: bool
    jobs: int
    executor: Executor | None
    progress: Progress
    clips: Clips = field(default_factory=dict, init=False)
    hand_clips: Clips = field(default_factory=dict, init=False)
    failed: dict[str, MotionError] = field(default_factory=dict, init=False)
    rig: Rig | None = field(default=None, init=False)
    hybrids: Hybrids = field(default_factory=dict, init=False)

    def run(self) -> Outcome:
        """Runs all stages, after any other job for the same folder. Raises MotionError."""
        pairs = self.find_clips()
        if self.skeleton is not None:  # before clips are read, because that takes long
            self.rig = rig_of(self.skeleton, self.roles)
        with destination(self.out, self.progress) as place, closing(Readings(place.cache)) as clips:
            return self.build(pairs, place, clips)

    def build(self, pairs: Sequence[HandsOnBody], place: Destination, clips: Readings) -> Outcome:
        """Runs the stages that follow `find_clips`. Raises MotionError."""
        cache, hands = place.cache, HandsReading(place.cache)
        search = StrideSearch(clips)
        candidates = self.find_strides(search)
        stride, used = self.on_skeleton(clips, self.choose_baseline(search, candidates))
        self.read_hands(hands)
        preparation = Preparation.of(clips, with_fingers(stride, hands, self.hand_clips), self.retarget)
        aligned, new, cut = self.align(preparation)
        laying = HandsLaying(preparation, hands)
        tasks = self.lay_hands(laying, tasks_of(pairs, aligned, self.hand_clips))
        recipe = preparation.recipe(aligned, recipe_of(laying, tasks))
        digest = cache.load(recipe, lambda fields, _: str(fields["bank"]))
        unchanged = digest is not None and place.holds(digest)
        if digest is None or not unchanged:
            digest = place.write(lambda folder: self.write(folder, preparation, aligned, laying, tasks))
            with suppress(MotionError):  # the bank is in place; the next run writes it again
                cache.store(recipe, {"bank": digest}, {})
        used |= {work.key(one) for work in (search, preparation) for one in self.clips.values()}
        used |= {hands.key(one) for one in self.hand_clips.values()} | {laying.key(task) for task in tasks.values()}
        cache.keep_only({recipe, search.choice_key(candidates), cut, *used})
        failed = dict(sorted(self.failed.items()))
        return Outcome(digest, preparation.ring, tuple(aligned), failed, len(aligned.keys() - new), unchanged)

    def find_clips(self) -> list[HandsOnBody]:
        """Finds the files, digests them and separates the hands clips. Returns which hands go on which bodies."""
        sources = find_sources(self.paths, self.roles, self.settings)
        files = list(dict.fromkeys(source.file for source in sources))  # a file may hold many clips
        contents = dict(zip(files, read_ahead(_contents_or_error, files, lambda file: file), strict=True))
        for source in sources:
            found = contents[source.file]
            if isinstance(found, MotionError):
                self.failed[source.name] = found
            else:
                self.clips[source.name] = identify(source, found)
        pairs = all_hands(self.hands, sources)
        names = sorted({pair.hands for pair in pairs} & self.clips.keys())
        self.hand_clips = {name: self.clips.pop(name) for name in names}
        return pairs

    def find_strides(self, search: StrideSearch) -> Clips:
        """Searches clips that may be the baseline for a stride. Returns those that could be read."""
        candidates = {name: one for name, one in self.clips.items() if self._may_be_baseline(one)}
        self._do("reading", search, candidates)
        return self._without_failed(candidates)

    def choose_baseline(self, search: StrideSearch, candidates: Clips) -> FoundStride:
        """Returns the named clip's stride, or the most typical one. Raises BaselineError."""
        if self.baseline is None:
            return typical_stride(search, candidates, self.failed)
        return named_stride(self.baseline, search, self.clips, self.failed)

    def on_skeleton(self, readings: Readings, stride: FoundStride) -> tuple[FoundStride, set[str]]:
        """Returns the baseline's stride on the skeleton of the user's choice, if there is one, and its cache keys.

        Raises BaselineError if the baseline does not fit it.
        """
        if self.rig is None:
            return stride, set()
        search = StrideOnSkeleton(readings, self.rig, self.retarget)
        baseline = self.clips[stride.ring.name]
        return load_or_run(search, baseline), {search.key(baseline)}

    def read_hands(self, readings: HandsReading) -> None:
        """Reads the hands clips, and drops those that fail."""
        self._do("hands", readings, self.hand_clips)
        self.hand_clips = self._without_failed(self.hand_clips)

    def align(self, preparation: Preparation) -> tuple[Clips, set[str], str]:
        """Prepares all clips, and the stretches of hybrids.

        Returns those that did not fail, the names of those that no earlier run had done, and the key of what was found
        of hybrids. Raises BaselineError if the baseline itself failed.
        """
        new = self._do("aligning", preparation, self._without_failed(self.clips))
        whole = self._without_failed(self.clips)
        self.hybrids = hybrids_among(preparation, whole, self.failed)
        stretches = {name: one for clips in self.hybrids.values() for name, one in clips.items()}
        new |= self._do("aligning", preparation, stretches)
        self.clips = dict(sorted((self.clips | stretches).items()))
        fail_whole(self.hybrids, self.failed)
        fail_with_missing_limbs(self.clips, preparation.rig, self.failed)
        fail_without_neutral(self.clips, self.failed)
        if preparation.ring.name in self.failed:
            raise BaselineError(f"the baseline cannot be used: {self.failed[preparation.ring.name]}")
        return self._without_failed(self.clips), new, cuts_key(preparation, whole)

    def lay_hands(self, laying: HandsLaying, tasks: Mapping[str, HandsTask]) -> dict[str, HandsTask]:
        """Lays hands on bodies. Returns the tasks that did not fail."""
        self._do("laying", laying, tasks)
        return self._without_failed(tasks)

    def write(
        self,
        folder: Path,
        preparation: Preparation,
        aligned: Clips,
        laying: HandsLaying,
        tasks: Mapping[str, HandsTask],
    ) -> str:
        """Writes the bank, and returns its digest."""
        preparation.cache.read_ahead(preparation.key(one) for one in aligned.values())
        clips, ring = BankClips(preparation, aligned, self.hybrids), preparation.ring
        clips = replace(clips, labels=labels_of(clips, ring.name))
        hands = [load_or_run(laying, task) for task in tasks.values()]
        hands += hands_on_stretches(hands, clips, preparation.rig)
        return write_bank(folder, preparation.rig, ring, clips, hands)

    def _do(self, stage: str, work: Work[Task, object], tasks: Mapping[str, Task]) -> set[str]:
        """Does the work on tasks whose results are not cached, and returns their names."""
        new = {name: one for name, one in tasks.items() if not work.cache.holds(work.key(one))}
        names = {id(one): name for name, one in new.items()}
        with closing(self._outcomes(work, list(new.values()))) as outcomes:
            for done, (one, result) in enumerate(outcomes, 1):
                if isinstance(result, CacheError | StorageError):
                    raise result  # no fault of the clip: a bank without it would take the place of a better one
                if isinstance(result, MotionError):
                    name = names[id(one)]
                    result = result.of(name) if isinstance(result, WorkerDiedError) else result
                    self.failed[name] = result.within(one.files)
                self.progress(stage, done, len(new))
        return set(new)

    def _outcomes(self, work: Work[Task, object], tasks: Sequence[Task]) -> Outcomes[Task, None]:
        """Does the work in the executor, or in as many processes as it is worth."""
        if self.executor is not None:
            return in_executor(self.executor, work.run, tasks)
        processes = min(self.jobs, len(tasks), sum(one.size for one in tasks) // WORTH_A_PROCESS)
        return in_processes(processes, work.run, tasks) if processes > 1 else one_after_another(work.run, tasks)

    def _without_failed(self, tasks: Mapping[str, Task]) -> dict[str, Task]:
        return {name: one for name, one in tasks.items() if name not in self.failed}

    def _may_be_baseline(self, one: Identified) -> bool:
        source = one.source
        return source.settings.kind == "locomotion" if self.baseline is None else source.name == self.baseline


def _contents_or_error(file: Place) -> Contents | MotionError:
    try:
        return contents_of(file)
    except StorageError:
        raise
    except MotionError as error:
        return error
