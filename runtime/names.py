"""The clips and hands of a bank by name and by number, as its manifest lists them."""

from __future__ import annotations

from functools import cached_property

from motionsplice.motion.errors import UnknownClipError, did_you_mean
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.runtime.format.entries import BaselineEntry, ClipEntry, HandsEntry
from motionsplice.runtime.format.manifest import Manifest
from motionsplice.runtime.mirrored import MIRRORED, mirrored_entry


class Names:
    """The contents of a bank by name: its skeleton, its clips, their mirror images, and its hands."""

    manifest: Manifest

    @property
    def skeleton(self) -> Skeleton:
        """The skeleton of all clips: J joints, parents before children."""
        return self.manifest.skeleton

    @property
    def roles(self) -> Roles:
        """The joints that are the pelvis, the shoulders and so on."""
        return self.manifest.roles

    @property
    def mirror(self) -> Mirror | None:
        """How the rig is mirrored; None if left and right limbs hang on different joints."""
        return self.manifest.mirror

    @property
    def baseline(self) -> BaselineEntry:
        """The stride that all clips are aligned to."""
        return self.manifest.baseline

    @property
    def clips(self) -> tuple[ClipEntry, ...]:
        """The entries of all clips, in order of name."""
        return self.manifest.clips

    @cached_property
    def numbered(self) -> tuple[ClipEntry, ...]:
        """The entries of all clips, then of all mirror images; the number of either is its index here."""
        return self.clips if self.mirror is None else (*self.clips, *map(mirrored_entry, self.clips))

    @property
    def hands(self) -> tuple[HandsEntry, ...]:
        """The entries of all hands clips, one for each clip that they are aligned to."""
        return self.manifest.hands

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {clip.name: number for number, clip in enumerate(self.numbered)}

    def number(self, name: str) -> int:
        """Returns the number of a clip: its index in `numbered`.

        Raises:
            UnknownClipError: The bank has no such clip. Suggests similar names.
        """
        try:
            return self._numbers[name]
        except KeyError:
            problem = f"the bank has no clip {name!r:.200}"
            mend = did_you_mean(name, [clip.name for clip in self.clips])
            if self.mirror is None and name.removesuffix(MIRRORED) in self._numbers:
                mend = "Its rig has no mirror image, because left and right limbs hang on different joints"
            raise UnknownClipError(problem, mend=mend) from None

    def clip(self, name: str) -> ClipEntry:
        """Returns the entry of a clip.

        Raises:
            UnknownClipError: The bank has no such clip. Suggests similar names.
        """
        return self.numbered[self.number(name)]

    @cached_property
    def _wholes(self) -> dict[str, tuple[str, float]]:
        wholes = {}
        for hybrid in self.numbered:
            begin = 0.0
            for one in map(self.clip, hybrid.stretches):
                wholes[one.name] = hybrid.name, begin
                begin += (one.leaves - one.enters) / one.rate
        return wholes

    def whole(self, name: str) -> str:
        """Returns the name of the hybrid action of which a clip is a stretch; the clip's own if it is none."""
        return self._wholes.get(name, (name, 0.0))[0]

    def begin_of(self, name: str) -> float:
        """Returns the seconds into its hybrid action at which a stretch takes over; 0 for any other clip."""
        return self._wholes.get(name, (name, 0.0))[1]

    @cached_property
    def hand_clips(self) -> tuple[str, ...]:
        """Names of all hands clips, sorted; the number of a hands clip is its index here."""
        return tuple(sorted({one.name for one in self.hands}))

    @cached_property
    def _hand_numbers(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(self.hand_clips)}

    def hand_number(self, name: str) -> int:
        """Returns the number of a hands clip: its index in `hand_clips`.

        Raises:
            UnknownClipError: The bank has no such hands. Suggests similar names.
        """
        if name in self._hand_numbers:
            return self._hand_numbers[name]
        problem = f"the bank has no hands {name!r:.200}"
        if not self.hand_clips:
            raise UnknownClipError(problem, mend="Build it with `motionsplice precompute --hands BODY:HANDS`")
        raise UnknownClipError(problem, mend=did_you_mean(name, self.hand_clips))

    def hands_not_aligned(self, name: str, body: str) -> UnknownClipError:
        """Returns the error for hands that are not aligned to the clip `body`; it lists the clips they fit."""
        bodies = ", ".join(repr(one.body) for one in self.hands if one.name == name)
        problem = f"hands {name!r} are not aligned to clip {body!r}"
        return UnknownClipError(problem, mend=f"They are aligned to {bodies}")
