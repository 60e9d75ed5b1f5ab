"""Hands on a body as a bank stores them: rows parallel to the body's own, with all joints that hands can drive."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.reading import Reading
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import SIDES
from motionsplice.precompute.hands.settings import HandSettings
from motionsplice.precompute.hands.splice import splice_hands
from motionsplice.precompute.preparation.prepared import PreparedClip
from motionsplice.precompute.preparation.seam import bent_onto
from motionsplice.runtime.format.rows import Layout


@dataclass(frozen=True, eq=False)
class LaidHands:
    """Hands laid on a body.

    name, body: the names of the hands clip and of the body. rate: of the hands clip, frames per second. rows: [n,
    columns], parallel to the body's n rows. frames: [n, 2] the real-valued frames of the hands clip that left and right
    hand show in each row. mismatch: `HandSplice.mismatch`. warnings: for the user. source: digest of the hands' file.
    """

    name: str
    body: str
    rate: float
    settings: HandSettings
    rows: NDArray[np.float32]
    frames: Floats
    mismatch: float
    warnings: tuple[str, ...]
    source: str = ""


def lay_hands(prepared: PreparedClip, layout: Layout, rig: Rig, reading: Reading, settings: HandSettings) -> LaidHands:
    """Aligns the hands of a clip to a prepared clip of a bank with this rig, and lays them on its rows.

    Joints that the hands do not drive keep the body's own numbers. Raises MotionError if hands and body do not fit.
    """
    roots, rotations = layout.motion(prepared.fetch("lower"), prepared.fetch("upper"))
    whole = Clip(prepared.name, rig.skeleton, prepared.rate, roots, rotations)
    count = prepared.frame_count
    body, roles, hands, hand_roles = whole.frames(0, count), rig.roles, reading.clip, reading.roles
    spliced = splice_hands(body, roles, hands, hand_roles, settings)
    frames = np.stack([spliced.frames.get(side, np.zeros(count)) for side in SIDES], axis=1)
    rows, frames = _with_seam(prepared, layout, spliced.clip, frames)
    warnings = (*reading.warnings, *spliced.warnings)
    return LaidHands(hands.name, prepared.name, hands.rate, settings, rows, frames, spliced.mismatch, warnings)


def hands_on_stretch(laid: LaidHands, stretch: PreparedClip, layout: Layout, rig: Rig) -> LaidHands:
    """Returns hands on a hybrid as hands on one of its stretches, which has a seam of its own."""
    assert stretch.cut is not None
    within = slice(stretch.cut.begin, stretch.cut.end)
    rotations = np.tile(quaternion.IDENTITY, (stretch.frame_count, rig.skeleton.joint_count, 1))
    rotations[:, layout.hands.joints] = layout.hands.lanes(laid.rows[within])[:, : len(layout.hands.joints)]
    shown = Clip(stretch.name, rig.skeleton, stretch.rate, np.zeros((len(rotations), 3)), rotations)
    rows, frames = _with_seam(stretch, layout, shown, laid.frames[within])
    return replace(laid, body=stretch.name, rows=rows, frames=frames, warnings=())


def _with_seam(
    prepared: PreparedClip, layout: Layout, merged: Clip, frames: Floats
) -> tuple[NDArray[np.float32], Floats]:
    """Returns the rows of hands [rows, columns], and their frames [rows, 2], for a body's own frames and its seam."""
    laid = merged.rotations
    if prepared.strides:
        after = _counterparts(prepared)
        joints = list(layout.hands.joints)
        seam = np.tile(quaternion.IDENTITY, (len(after) - 2, laid.shape[1], 1))
        seam[:, joints] = bent_onto(laid[-2:, joints], merged.sampled(after)[1][:, joints])
        laid = np.concatenate([laid, seam])
        along = np.arange(merged.frame_count)
        frames = np.concatenate([frames, np.stack([np.interp(after[2:], along, side) for side in frames.T], axis=1)])
    return layout.pack_hands(quaternion.one_hemisphere(laid)), frames


def _counterparts(prepared: PreparedClip) -> Floats:
    """Returns the real-valued counterparts [2 + n] of the clip's last two frames and of its seam's n frames."""
    own = prepared.phase[: prepared.frame_count]
    count, last = len(prepared.phase) - len(own), len(own) - 1.0 - prepared.period
    if not prepared.period:  # the seam ends in step
        last = float(np.interp(prepared.phase[-1] - prepared.strides, own, np.arange(len(own)))) - count
    return last + np.arange(-1.0, count + 1.0)
