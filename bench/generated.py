"""Generated banks of any size: smooth, meaningless motion in tables that `Bank.open` accepts.

The cost of a splice depends on where its rows lie, not on their values. So a bank has only as many different motions
as fit into `MOST_DRAWN` rows. Its clips repeat these motions, each clip in its own rows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.parts import PARTS, UPPER_BODY
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, find_roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.body.contacts import support
from motionsplice.precompute.body.posture import measure_torso
from motionsplice.precompute.job.bank_builder import CELLS_PER_FRAME, frame_of_phase, write_manifest
from motionsplice.precompute.job.written import Parts, write_tables
from motionsplice.precompute.preparation.feet import standing_feet
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.contacts import LEFT_FOOT, RIGHT_FOOT
from motionsplice.runtime.format.entries import BaselineEntry, ClipEntry, HandsEntry
from motionsplice.runtime.format.manifest import TABLES
from motionsplice.runtime.format.packed_rows import packed
from motionsplice.runtime.format.rows import Layout, TorsoRows
from motionsplice.runtime.format.tables import TABLE_FOLDER

FEWEST_JOINTS, MOST_JOINTS = 15, 300  # with fewer joints, some role has none
MOST_DRAWN = 50_000  # rows
HANDS = "hands"  # the name of the hands layer, which every clip has
STRIDE, SEAM, SHORTEST = 1.1, 0.2, 3.0  # seconds


@dataclass(frozen=True)
class Size:
    """The size of a generated bank: `clips` clips of `seconds` each at `rate` frames per second.

    With `hands`, each clip also has a hands layer. With `standing`, each clip is a standing action. Raises
    SettingsError if `joints` is outside FEWEST_JOINTS to MOST_JOINTS, without clips, or for clips below SHORTEST.
    """

    joints: int = 31
    clips: int = 40
    seconds: float = 10.0
    rate: float = 30.0
    hands: bool = False
    standing: bool = False

    def __post_init__(self) -> None:
        if not (FEWEST_JOINTS <= self.joints <= MOST_JOINTS and self.clips >= 1 and self.seconds >= SHORTEST):
            raise SettingsError(
                f"{self.clips} clips of {self.seconds} s on {self.joints} joints cannot be generated",
                mend=f"Ask for {FEWEST_JOINTS} to {MOST_JOINTS} joints, and one clip or more of at least {SHORTEST} s",
            )

    @property
    def frames(self) -> int:
        return round(self.seconds * self.rate) + 1

    @property
    def rows(self) -> int:
        """Rows of one clip, including its seam."""
        return self.frames + round(SEAM * self.rate)


@dataclass(frozen=True, eq=False)
class _Drawn:
    """One random motion, as the table rows and cells of a clip, and its phase in cycles."""

    tables: Mapping[str, NDArray[Any]]
    phase: Floats


def generate(path: Path, size: Size, seed: int = 0) -> Bank:
    """Writes a generated bank to the folder `path` and opens it with verification, so all of it has been read."""
    skeleton = skeleton_of(size.joints)
    roles = find_roles(skeleton)
    random = np.random.default_rng(seed)
    drawn = [_draw(skeleton, roles, size, random) for _ in range(max(1, min(size.clips, MOST_DRAWN // size.rows)))]
    motions = list(islice(cycle(drawn), size.clips))
    folder = path / TABLE_FOLDER
    folder.mkdir(parents=True)
    stances = [motion.tables["upper"][: size.standing] for motion in motions]  # the first rows
    parts: dict[str, Parts] = {
        "neutral": (size.clips, [np.arange(size.clips)]),
        "stances": (size.clips * size.standing, stances),
    }
    for name in TABLES.keys() - parts.keys():
        parts[name] = (size.clips * len(motions[0].tables[name]), [motion.tables[name] for motion in motions])
    digests = write_tables(folder, parts)
    entries = [_entry(number, motion.phase, size) for number, motion in enumerate(motions)]
    hands = [
        HandsEntry(HANDS, entry.name, entry.first_row, size.rate, "both", False, (), 0.0, (), "generated")
        for entry in entries
        if size.hands
    ]
    baseline = BaselineEntry(entries[0].name, 0.0, STRIDE, 0.0, 32)
    write_manifest(path, skeleton, roles, None, baseline, entries, digests, hands)
    return Bank.open(path)


def skeleton_of(joints: int) -> Skeleton:
    """A body of FEWEST_JOINTS to MOST_JOINTS joints. Joints left over after trunk, limbs, head and toes are fingers."""
    names: list[str] = []
    parents: list[int] = []
    offsets: list[tuple[float, float, float]] = []

    def add(name: str, above: str | None, x: float, y: float, z: float = 0.0) -> str:
        parents.append(-1 if above is None else names.index(above))
        names.append(name)
        offsets.append((x, y, z))
        return name

    spare = joints - FEWEST_JOINTS
    trunk, toes, head = min(spare, 2), spare >= 4, spare >= 6
    fingers = spare - trunk - 2 * toes - 2 * head
    root = add("Hips", None, 0.0, 0.95)
    for side, x in (("Left", 1.0), ("Right", -1.0)):
        above = add(f"{side}UpLeg", root, 0.09 * x, -0.05)
        above = add(f"{side}Leg", above, 0.0, -0.42)
        above = add(f"{side}Foot", above, 0.0, -0.41)
        if toes:
            add(f"{side}ToeBase", above, 0.0, -0.06, 0.13)
    chest = add("Spine", root, 0.0, 0.08)
    for number in range(1 + trunk):
        chest = add(f"Spine{number + 1}", chest, 0.0, 0.12)
    if head:
        add("Head", add("Neck", chest, 0.0, 0.2), 0.0, 0.12)
    for side, x in (("Left", 1.0), ("Right", -1.0)):
        above = add(f"{side}Arm", chest, 0.17 * x, 0.12)
        above = add(f"{side}ForeArm", above, 0.27 * x, 0.0)
        hand = add(f"{side}Hand", above, 0.25 * x, 0.0)
        for number in range((fingers + (side == "Left")) // 2):
            above = add(f"{side}Finger{number}", hand if number % 3 == 0 else above, 0.03 * x, 0.0)
    return Skeleton(tuple(names), np.array(parents), np.array(offsets), np.empty(0, np.int64), np.empty((0, 3)))


def _draw(skeleton: Skeleton, roles: Roles, size: Size, random: np.random.Generator) -> _Drawn:
    """Draws a motion that repeats with the stride, so that it can loop after any whole number of strides."""
    seconds = np.arange(size.rows) / size.rate
    strides = seconds / (STRIDE * random.uniform(0.9, 1.1))
    phase = random.random() + strides + 0.02 * np.sin(2.0 * np.pi * strides)  # always increases, as 0.02 * 2 pi < 1
    axes = random.normal(size=(skeleton.joint_count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    swing = random.uniform(0.05, 0.5, (2, skeleton.joint_count)) * [[1.0], [0.3]]
    swing[:, 0] *= 0.2
    shifts = random.random((2, skeleton.joint_count))
    turns = sum(swing[k] * np.sin(2.0 * np.pi * (k + 1) * (phase[:, None] + shifts[k])) for k in range(2))
    rotations = quaternion.about(axes, turns)
    roots = np.stack([0.02 * np.sin(2.0 * np.pi * phase), np.full(size.rows, 0.95), 1.3 * seconds], axis=1)
    clip = Clip("drawn", skeleton, size.rate, roots, rotations)
    torso = measure_torso(clip, roles)
    offsets = quaternion.about(axes[roles.pelvis], 0.1 * np.sin(2.0 * np.pi * phase))
    layout = Layout.of(skeleton, roles)
    rows = packed(layout, roots, rotations, TorsoRows(torso.clouds, torso.frames, offsets))
    layout.set_usage(rows["upper"], size.standing * (0.5 + 0.5 * np.sin(2.0 * np.pi * phase))[:, None] * np.ones(PARTS))
    path = np.column_stack([np.zeros((size.rows, 2)), roots[:, 2], np.zeros(size.rows)])
    feet = np.where(phase % 1.0 < 0.6, LEFT_FOOT, 0) | np.where((phase + 0.5) % 1.0 < 0.6, RIGHT_FOOT, 0)
    count = size.rows if size.hands else 0
    places = standing_feet(clip, path, support(feet.astype(np.uint8), size.rate), roles)
    ground: dict[str, NDArray[Any]] = {"paths": path, "contacts": feet, "feet": places}
    hands: dict[str, NDArray[Any]] = {
        "hands": layout.pack_hands(rotations[::-1][:count]),
        "hand_frames": np.zeros((count, 2)),
    }
    rest = {"phase_of_frame": phase, "frame_of_phase": frame_of_phase(phase), "postures": torso.posture[None]}
    return _Drawn({**rows, **rest, **ground, **hands}, phase)


def _entry(number: int, phase: Floats, size: Size) -> ClipEntry:
    first, last = float(phase[0]), float(phase[-1])
    return ClipEntry(
        name=f"clip{number:05d}",
        kind="locomotion",
        tags=(),
        rate=size.rate,
        first_row=number * size.rows,
        frame_count=size.frames,
        row_count=size.rows,
        first_cell=number * size.rows * CELLS_PER_FRAME,
        cell_count=size.rows * CELLS_PER_FRAME,
        first_phase=first,
        last_phase=last,
        cycles=float(phase[size.frames - 1]) - first,
        loop=int(last - first) - 1,
        gait=True,
        mean_mismatch=0.0,
        worst_mismatch=0.0,
        shoulder_motion=0.0,
        repetition=0.0,
        stance=number if size.standing else -1,
        parts=UPPER_BODY,
        uses=(),
        stretches=(),
        enters=0.0,
        leaves=0.0,
        warnings=(),
        notes=(),
        source="generated",
    )
