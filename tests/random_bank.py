"""Banks of random numbers, for properties that hold for any skeleton, any rows and any clouds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.mirror import Mirror
from motionsplice.motion.parts import PARTS, UPPER_BODY
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.job.bank_builder import frame_of_phase
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.entries import BaselineEntry, ClipEntry, HandsEntry
from motionsplice.runtime.format.manifest import TABLES, Manifest
from motionsplice.runtime.format.packed_rows import packed, packed_stance
from motionsplice.runtime.format.rows import Layout, TorsoRows

CLOUDS = ("torso", "line", "point")
RATE = 30.0


def random_bank(seed: int, joints: int, clips: int, points: int, clouds: str, hybrids: bool = False) -> Bank:
    """Returns a bank in memory. The `points` of its upper cloud lie as in a torso, on a line or in one point.

    With `hybrids`, every third clip plays the two after it, one of which stands.
    """
    draw = np.random.default_rng(seed)
    skeleton = Skeleton(
        names=tuple(f"joint {number}" for number in range(joints)),
        parents=np.array([-1, *(draw.integers(0, child) for child in range(1, joints))]),
        offsets=draw.normal(size=(joints, 3)),
        end_parents=np.zeros(0, np.int64),
        end_offsets=np.zeros((0, 3)),
    )
    named = {field: int(draw.integers(1, joints)) for field in Roles.__annotations__ if field != "spine"}
    roles = Roles(**named, spine=tuple(draw.integers(1, joints, points - 2).tolist()))
    layout = Layout.of(skeleton, roles)
    tables: dict[str, list[Floats]] = {name: [] for name in TABLES}
    tables["hands"].append(np.zeros((0, layout.hands.columns)))
    tables["hand_frames"].append(np.zeros((0, 2)))
    tables["stances"].append(np.zeros((0, layout.upper.columns)))
    entries, row = [], 0
    hands, hand_row = [], 0
    for number in range(clips):
        frames, seam = int(draw.integers(2, 12)), int(draw.integers(0, 5))
        rows = frames + seam
        phase = draw.uniform(0.0, 1.0) + np.cumsum(draw.uniform(0.05, 0.4, rows))
        torso = TorsoRows(_cloud(draw, clouds, rows, points), *(_rotations(draw, rows, 1)[:, 0] for _ in range(2)))
        both = packed(layout, draw.normal(size=(rows, 3)), _rotations(draw, rows, joints), torso)
        for name, values in both.items():
            tables[name].append(np.asarray(values))
        tables["phase_of_frame"].append(phase)
        tables["frame_of_phase"].append(frame_of_phase(phase))
        tables["paths"].append(np.cumsum(draw.normal(size=(rows, 4)) * 0.02, axis=0))
        tables["contacts"].append(np.floor(draw.uniform(0.0, 4.0, rows)))
        tables["feet"].append(draw.uniform(0.0, 1.0, (rows, 6)))
        tables["postures"].append(draw.normal(size=(1, 2, 3)))
        tables["neutral"].append(np.array([number]))
        stands = number % 3 == 1
        layout.set_usage(np.asarray(tables["upper"][-1]), stands * draw.uniform(0.0, 1.0, (rows, PARTS)))
        if stands:
            tables["stances"].append(packed_stance(layout, _rotations(draw, 1, joints)[0]).astype(np.float64))
        if number % 2:
            tables["hands"].append(layout.pack_hands(_rotations(draw, rows, joints)).astype(np.float64))
            tables["hand_frames"].append(np.cumsum(draw.uniform(0.0, 2.0, (rows, 2)), axis=0))
            hands.append(HandsEntry("hands", f"clip {number}", hand_row, RATE, "both", False, (), 0.2, (), ""))
            hand_row += rows
        strides = int(phase[-1] - phase[0]) if seam and draw.random() < 0.7 else 0
        span = (float(phase[0]), float(phase[-1]), float(phase[frames - 1] - phase[0]))
        place = (row, frames, rows, 4 * row, 4 * rows)
        stance: tuple[int, int, tuple[str, ...]] = (-1, UPPER_BODY, ())
        if stands:
            stance = (number // 3, int(draw.integers(1, UPPER_BODY + 1)), ("trunk",))
        label, found = (f"clip {number}", "action", (), RATE), (0.0, 0.0, 0.0, 0.0)
        entries.append(ClipEntry(*label, *place, *span, strides, not stands, *found, *stance, (), 0.0, 0.0, (), (), ""))
        row += rows
    for number in range(0, clips - 2, 3) if hybrids else ():
        stretches = range(number + 1, number + 3)
        entries[number] = replace(entries[number], stretches=tuple(f"clip {one}" for one in stretches))
        for one in stretches:
            enters, leaves = np.sort(draw.uniform(0.0, entries[one].frame_count - 1.0, 2)).tolist()
            entries[one] = replace(entries[one], enters=enters, leaves=leaves)
    baseline = BaselineEntry("clip 0", 0.0, 1.0, 0.0, 30)
    listed, digests = (tuple(entries), tuple(hands)), dict.fromkeys(TABLES, "")
    manifest = Manifest(b"", "", skeleton, roles, _mirror(draw, layout, joints), baseline, *listed, digests)
    arrays: dict[str, NDArray[Any]] = {
        name: np.ascontiguousarray(np.concatenate(tables[name]), kind) for name, (kind, _) in TABLES.items()
    }
    return Bank(Path(), manifest, arrays)


def _mirror(draw: np.random.Generator, layout: Layout, joints: int) -> Mirror:
    """Pairs joints of each half at random, those of hands with such; about a quarter have no twin."""
    twins = np.arange(joints)
    hands = set(layout.hands.joints)
    for group in (layout.lower.joints, set(layout.upper.joints) - hands, hands):
        mixed = draw.permutation(sorted(group)).tolist()
        for one, other in zip(mixed[::2], mixed[1::2], strict=False):
            twins[one], twins[other] = (other, one) if draw.random() < 0.75 else (-1, -1)
    return Mirror(twins, Rotation.random(joints, random_state=draw).as_quat())


def _rotations(draw: np.random.Generator, rows: int, joints: int) -> Floats:
    """Rotations [rows, joints, 4] that change by up to a radian from row to row."""
    steps = Rotation.from_rotvec(draw.uniform(-0.5, 0.5, (rows * joints, 3))).as_quat().reshape(rows, joints, 4)
    steps[0] = Rotation.random(joints, random_state=draw).as_quat()
    for row in range(1, rows):
        steps[row] = quaternion.multiply(steps[row - 1], steps[row])
    return quaternion.one_hemisphere(steps)


def _cloud(draw: np.random.Generator, kind: str, rows: int, points: int) -> Floats:
    """Clouds [rows, points, 3], metres."""
    along = draw.uniform(0.05, 0.5, points)
    if kind == "point":
        return np.zeros((rows, points, 3))
    cloud = np.multiply.outer(along, [0.0, 1.0, 0.0])
    if kind == "torso":
        cloud[-2:, 0] += [0.2, -0.2]
        cloud = cloud + 0.03 * draw.normal(size=(rows, points, 3))
    turn = Rotation.random(random_state=draw).as_quat()
    return quaternion.rotate(turn, np.broadcast_to(cloud, (rows, points, 3)))
