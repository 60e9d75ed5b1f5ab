"""The parts of a bank's tables that belong to a clip or to hands."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.comparison import at_frames
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.parts import TWIN_PARTS
from motionsplice.runtime.format.checks import Tables
from motionsplice.runtime.format.contacts import Contact, contacts_of
from motionsplice.runtime.format.rows import Layout, TorsoRows
from motionsplice.runtime.format.standing import Standing
from motionsplice.runtime.mirrored import (
    HALF_A_CYCLE,
    mirrored_contacts,
    mirrored_name,
    mirrored_path,
    mirrored_posture,
    mirrored_rotations,
    mirrored_torso,
)
from motionsplice.runtime.names import Names


class Contents(Names):
    """The motions, phases, contacts and so on of a bank's clips and hands, by name."""

    tables: Tables

    @cached_property
    def layout(self) -> Layout:
        """The columns of the tables `lower`, `upper` and `hands`."""
        return Layout.of(self.skeleton, self.roles)

    def _mirror_of(self, name: str) -> Mirror | None:
        """Returns the mirror if a name is that of a mirror image, else None."""
        return self.mirror if self.number(name) >= len(self.clips) else None

    def hand_frames(self, name: str, body: str) -> NDArray[np.float64]:
        """Returns the frame [F, 2] of a hands clip that goes with each of the F frames of a clip: left, right hand.

        Args:
            name: The hands clip.
            body: The clip that it is aligned to.

        Raises:
            UnknownClipError: The bank has no such hands, or they are not aligned to `body`.
        """
        frames = self.tables["hand_frames"][self._hand_rows(name, body)[: self.clip(body).frame_count]]
        return np.asarray(frames[:, ::-1] if self._mirror_of(body) else frames)

    def hand_motion(self, name: str, body: str) -> NDArray[np.float64]:
        """Returns the rotations [rows, n, 4], xyzw, of the n joints `layout.hands.joints`: hands laid on a clip.

        Args:
            name: The hands clip.
            body: The clip that it is aligned to; its seam is included, so `rows` is its `row_count`.

        Raises:
            UnknownClipError: The bank has no such hands, or they are not aligned to `body`.
        """
        rows, joints = self.tables["hands"][self._hand_rows(name, body)], self.layout.hands.joints
        rotations = self.layout.hands.lanes(rows)[:, : len(joints)].astype(np.float64)
        if mirror := self._mirror_of(body):
            whole = np.zeros((len(rotations), self.skeleton.joint_count, 4))
            whole[:, joints] = rotations
            rotations = mirrored_rotations(whole, mirror, self.skeleton)[:, joints]
        return rotations

    def _hand_rows(self, name: str, body: str) -> NDArray[np.int64]:
        self.hand_number(name)
        for one in self.hands:
            if one.name == name and body in (one.body, mirrored_name(one.body)):
                return one.first_row + np.arange(self.clip(body).row_count)
        raise self.hands_not_aligned(name, body)

    def neutral(self, name: str) -> str:
        """Returns the name of the neutral of a clip: the clip that its posture is relative to.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        number, count = self.number(name), len(self.clips)
        return self.numbered[int(self.tables["neutral"][number % count]) + number // count * count].name

    def motion(self, name: str, *, seam: bool = False) -> Clip:
        """Returns a clip in its editable form, on the bank's skeleton.

        Args:
            name: The clip.
            seam: Whether to append the frames of its seam, which lead from its end back into the loop.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        return self._motion(name, self._rows(name, seam))

    def _motion(self, name: str, rows: slice | NDArray[np.int64]) -> Clip:
        roots, rotations = self.layout.motion(self.tables["lower"][rows], self.tables["upper"][rows])
        clip, mirror = Clip(name, self.skeleton, self.clip(name).rate, roots, rotations), self._mirror_of(name)
        return mirror.clip(clip) if mirror else clip

    def motion_at(self, name: str, frames: NDArray[np.float64]) -> Clip:
        """Returns a clip of real-valued `frames` [n] alone, for which only the rows beside them are read.

        Frames past the clip's last frame are in its seam.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        before, after, _ = quaternion.neighbours(self.clip(name).row_count, frames)
        needed = np.unique([before, after])
        clip = self._motion(name, needed + self.clip(name).first_row)
        return at_frames(clip, np.interp(frames, needed, np.arange(len(needed))))

    def torso(self, name: str, *, seam: bool = False) -> TorsoRows:
        """Returns how the upper body of a clip sits on its root at each frame; with `seam`, at those of its seam too.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        torso, mirror = self.layout.torso(self.tables["lower"][self._rows(name, seam)]), self._mirror_of(name)
        return mirrored_torso(torso, mirror, self.skeleton, self.roles) if mirror else torso

    def standing(self, name: str, *, seam: bool = False) -> Standing | None:
        """Returns how a standing action departs from its stance at each frame; None for any other clip.

        With `seam`, at the frames of its seam too.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        stance, rows = self.stance(name), self._rows(name, seam)
        if stance is None:
            return None
        usage = self.layout.usage(self.tables["upper"][rows])
        if self._mirror_of(name):
            usage = usage[:, list(TWIN_PARTS)]
        return Standing(stance, self.torso(name, seam=seam).offsets, usage, self.clip(name).parts)

    def stance(self, name: str) -> NDArray[np.float64] | None:
        """Returns the stance of a standing action; None for any other clip.

        It is local rotations [J, 4], xyzw: identities for the joints that are not of the upper body.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        entry, mirror = self.clip(name), self._mirror_of(name)
        if not entry.stands:
            return None
        bind = np.tile(quaternion.IDENTITY, (self.skeleton.joint_count, 1))
        stance = self.layout.stance(self.tables["stances"][entry.stance], bind)
        return mirrored_rotations(stance, mirror, self.skeleton) if mirror else stance

    def phase(self, name: str, *, seam: bool = False) -> NDArray[np.float64]:
        """Returns the phase [F] of each frame of a clip, in cycles of the baseline; with `seam`, of its seam's too.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        phase = np.asarray(self.tables["phase_of_frame"][self._rows(name, seam)])
        return phase + HALF_A_CYCLE if self._mirror_of(name) else phase

    def phase_at(self, name: str, seconds: float) -> float:
        """Returns the phase of a clip at a time, in cycles of the baseline; times outside it are clamped to its ends.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        entry = self.clip(name)
        frame = min(max(seconds * entry.rate, 0.0), entry.frame_count - 1.0)
        before = min(int(frame), entry.frame_count - 2)
        here, after = self.tables["phase_of_frame"][entry.first_row + before :][:2]
        return float(here + (frame - before) * (after - here)) + (HALF_A_CYCLE if self._mirror_of(name) else 0.0)

    def root_path(self, name: str, *, seam: bool = False) -> NDArray[np.float64]:
        """Returns the root path [F, 4] of a clip: x, ground height and z in metres, heading in radians about Y.

        With `seam`, the frames of its seam are included.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        path = np.asarray(self.tables["paths"][self._rows(name, seam)])
        return mirrored_path(path) if self._mirror_of(name) else path

    def posture(self, name: str) -> NDArray[np.float64]:
        """Returns the posture [2, 3] of a clip: the mean places of both shoulders in the posture frame, metres.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        posture = np.asarray(self.tables["postures"][self.number(name) % len(self.clips)])
        return mirrored_posture(posture) if self._mirror_of(name) else posture

    def contacts(self, name: str) -> list[Contact]:
        """Returns the times at which each foot of a clip is on the ground, in order of time.

        Raises:
            UnknownClipError: The bank has no such clip.
        """
        standing = self.tables["contacts"][self._rows(name, False)]
        return contacts_of(mirrored_contacts(standing) if self._mirror_of(name) else standing, self.clip(name).rate)

    def _rows(self, name: str, seam: bool) -> slice:
        entry = self.clip(name)
        return slice(entry.first_row, entry.first_row + (entry.row_count if seam else entry.frame_count))
