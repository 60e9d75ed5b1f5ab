"""The splice written with NumPy: whole batches at once, posture `relative` (docs/bank.md, by hand).

Each step is an array operation over all characters. So there is no Python loop, but each step reads and writes whole
arrays. The kernels are measured against this version. It also computes which rows a splice reads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.pointcloud import horn_rotation
from motionsplice.motion.quaternion import Floats
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.rows import CLOUD, FIRST_JOINT, PELVIS, POSTURE_FRAME, ROOT, TORSO_OFFSET
from motionsplice.runtime.kernels.lookup import IN_STEP
from motionsplice.runtime.requests import METHODS, Poses, Requests

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Places:
    """Positions of n characters in a table: between `rows` [n] and the next rows, at the fractions `shares` [n]."""

    rows: Integers
    shares: Floats


class NumpyTwin:
    """Evaluates splices of a bank's clips, in float64."""

    def __init__(self, bank: Bank) -> None:
        self._tables, self._layout = bank.tables, bank.layout
        names = ("first_row", "frame_count", "row_count", "first_cell", "cell_count", "loop")
        (
            self._first_row, self._frames, self._rows, self._first_cell, self._cells, self._loop,
        ) = (np.array([getattr(clip, name) for clip in bank.clips], np.int64) for name in names)  # fmt: skip
        self._rate, self._first, self._last = (
            np.array([getattr(clip, name) for clip in bank.clips]) for name in ("rate", "first_phase", "last_phase")
        )

    def evaluate(self, requests: Requests, out: Poses) -> None:
        """Writes the poses of splices with posture `relative`. Ignores the method and posture of the requests."""
        below, above = self.splice_places(requests)
        layout, lower, upper = self._layout, self._tables["lower"], self._tables["upper"]
        before_l, after_l, before_u, after_u = (
            table[place.rows + step] for table, place in ((lower, below), (upper, above)) for step in (0, 1)
        )
        out.root_positions[:] = _mix(before_l[:, ROOT : ROOT + 3], after_l[:, ROOT : ROOT + 3], below.shares)
        lanes_l = quaternion.slerp(layout.lower.lanes(before_l), layout.lower.lanes(after_l), below.shares[:, None])
        lanes_u = quaternion.slerp(layout.upper.lanes(before_u), layout.upper.lanes(after_u), above.shares[:, None])
        for half, lanes in ((layout.lower, lanes_l), (layout.upper, lanes_u)):
            out.rotations[:, half.joints] = lanes[:, FIRST_JOINT : FIRST_JOINT + len(half.joints)]
        cloud, planes = slice(CLOUD, CLOUD + 3 * layout.cloud_width), (-1, 3, layout.cloud_width)
        # Padding consists of points at the origin, which add nothing.
        target = _mix(before_l[:, cloud], after_l[:, cloud], below.shares).reshape(planes).swapaxes(1, 2)
        source = _mix(before_u[:, cloud], after_u[:, cloud], above.shares).reshape(planes).swapaxes(1, 2)
        aligned = quaternion.multiply(lanes_l[:, PELVIS], horn_rotation(target, source))
        turn = quaternion.multiply(lanes_u[:, TORSO_OFFSET], quaternion.conjugate(lanes_l[:, TORSO_OFFSET]))
        frame = lanes_l[:, POSTURE_FRAME]
        lean = quaternion.multiply(quaternion.multiply(frame, turn), quaternion.conjugate(frame))
        out.rotations[:, layout.pelvis] = quaternion.multiply(lean, aligned)

    def splice_places(self, requests: Requests) -> tuple[Places, Places]:
        """Returns the positions in the tables `lower` and `upper`, as if all requests were splices."""
        clip_l, clip_u, phases = requests.locomotion, requests.action, self._tables["phase_of_frame"]
        below = self._own_places(clip_l, requests.time)
        phase = _between(phases, below)
        begin = _between(phases, self._own_places(clip_u, requests.start))
        phase += np.ceil(begin - self._first[clip_l] - IN_STEP)
        loop = self._loop[clip_u]
        behind = np.ceil((phase - self._last[clip_u]) / np.maximum(loop, 1))
        phase -= np.where((loop > 0) & (behind > 0.0), loop * behind, 0.0)
        cycles = self._last[clip_u] - self._first[clip_u]
        cells = (phase - self._first[clip_u]) * ((self._cells[clip_u] - 1) / cycles)
        frame = _between(self._tables["frame_of_phase"], _locate(cells, self._first_cell[clip_u], self._cells[clip_u]))
        for _ in range(2):  # like the kernels, refines the table's approximate frame to the exact one
            rows = _locate(frame, self._first_row[clip_u], self._rows[clip_u]).rows
            frame = rows - self._first_row[clip_u] + (phase - phases[rows]) / (phases[rows + 1] - phases[rows])
        return below, _locate(frame, self._first_row[clip_u], self._rows[clip_u])

    def places(self, requests: Requests) -> tuple[Places, Places]:
        """Returns the positions in the tables `lower` and `upper` for each request's own method."""
        below, above = self.splice_places(requests)
        clip_u = requests.action
        last = (self._frames[clip_u] - 1) / self._rate[clip_u]
        seconds = requests.start + requests.time
        repeated = self._own_places(clip_u, np.where(seconds <= last, seconds, np.mod(seconds, last)))
        for method, own in (("naive", repeated), ("none", below)):
            theirs = requests.method == METHODS[method]
            above.rows[theirs], above.shares[theirs] = own.rows[theirs], own.shares[theirs]
        return below, above

    def _own_places(self, clips: NDArray[np.int32], seconds: Floats) -> Places:
        return _locate(seconds * self._rate[clips], self._first_row[clips], self._frames[clips])


def _locate(at: Floats, first: Integers, count: Integers) -> Places:
    clamped = np.clip(at, 0.0, count - 1.0)
    before = np.minimum(clamped.astype(np.int64), count - 2)
    return Places(first + before, clamped - before)


def _between(table: NDArray[np.floating], place: Places) -> Floats:
    here = table[place.rows].astype(np.float64)
    return here + place.shares * (table[place.rows + 1] - here)


def _mix(before: NDArray[np.float32], after: NDArray[np.float32], shares: Floats) -> Floats:
    return np.asarray(before + shares[:, None] * (after - before), np.float64)
