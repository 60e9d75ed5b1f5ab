"""A close-up figure of a hand: forearm, palm and fingers, each finger with a casing against its background."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from motionsplice.motion.hand_joints import elbow_of, wrist_of
from motionsplice.motion.kinematics import end_positions, world_transforms
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles, Side
from motionsplice.motion.skeleton import Skeleton
from motionsplice.pictures.brush import WHITE, Brush, Colour, mixed
from motionsplice.pictures.stick_figure import GHOST, LEFT, RIGHT

# Radii in leg lengths.
FOREARM, KNUCKLE, TIP = 0.026, 0.0105, 0.0075
PALM, DOT, CASING = 0.013, 0.003, 0.004
VISIBLE = 0.45  # fraction of the forearm that is drawn, from the wrist
PALE = 0.25  # fraction of white in the palm, so that fingers curled over it stand out


@dataclass(frozen=True, eq=False)
class HandFigure:
    """How one hand of a rig is drawn. Points are its J joints, E end sites, and the cut through the forearm.

    fingers: the points of each finger, from the palm to the tip.
    unit:    length of a leg in metres, to which all thicknesses are relative.
    """

    skeleton: Skeleton
    elbow: int
    wrist: int
    fingers: tuple[tuple[int, ...], ...]
    colour: Colour
    unit: float

    @classmethod
    def of(cls, skeleton: Skeleton, roles: Roles, side: Side) -> HandFigure:
        """Returns the figure of one hand of a rig. A hand without fingers is forearm and palm."""
        elbow, wrist = elbow_of(roles, side), wrist_of(roles, side)
        below = skeleton.subtree(wrist)
        ends = enumerate(skeleton.end_parents.tolist(), skeleton.joint_count)
        above = {child: int(skeleton.parents[child]) for child in below[1:]} | {
            end: parent for end, parent in ends if parent in below
        }
        fingers = []
        for tip in above.keys() - set(above.values()):
            path = [tip]
            while path[-1] != wrist:
                path.append(above[path[-1]])
            fingers.append(tuple(path[-2::-1]))
        colour = LEFT if side == "left" else RIGHT
        return cls(skeleton, elbow, wrist, tuple(sorted(fingers)), colour, roles.leg_length(skeleton))

    def points(self, root_positions: Floats, rotations: Floats) -> Floats:
        """Returns the world positions [n, J + E + 1, 3] of all points, in metres, of poses [n, 3] and [n, J, 4]."""
        positions, world = world_transforms(self.skeleton, root_positions, rotations)
        cut = positions[:, self.wrist] + VISIBLE * (positions[:, self.elbow] - positions[:, self.wrist])
        return np.concatenate([positions, end_positions(self.skeleton, positions, world), cut[:, None]], axis=1)

    def middles(self, points: Floats, ground: float) -> Floats:
        """Returns the point at the middle of the view [n, 3]: the wrist."""
        return points[:, self.wrist]

    def bounds(self, points: Floats) -> Floats:
        """Returns the least and greatest coordinates [2, k] that the figure with points [n, P, k] covers, in metres."""
        drawn = points[:, [self.wrist, -1, *(point for finger in self.fingers for point in finger)]]
        radius = FOREARM * self.unit
        return np.stack([(drawn - radius).min(axis=(0, 1)), (drawn + radius).max(axis=(0, 1))])

    def paint(self, brush: Brush, points: Floats, *, fade: float = 0.0) -> None:
        """Paints a pose from back to front; points [P, 3] metres to the right, up and towards the viewer."""
        flat, depths = points[:, :2], points[:, 2]
        colour, wrist = mixed(self.colour, fade), self.wrist
        parts = sorted(self.fingers, key=lambda finger: depths[list(finger)].mean())
        bases = np.mean([depths[finger[0]] for finger in self.fingers]) if self.fingers else depths[wrist]
        palm = 0.5 * (depths[wrist] + bases)
        behind = [finger for finger in parts if depths[list(finger)].mean() < palm]
        brush.taper(flat[-1], flat[wrist], 1.2 * FOREARM * self.unit, FOREARM * self.unit, colour)
        for finger in behind:
            self._paint_finger(brush, flat, finger, colour)
        self._paint_palm(brush, flat, mixed(self.colour, fade + PALE * (1.0 - fade)))
        brush.disc(flat[wrist], 2.0 * DOT * self.unit, WHITE)
        for finger in parts[len(behind) :]:
            self._paint_finger(brush, flat, finger, colour)

    def paint_ghost(self, brush: Brush, points: Floats) -> None:
        """Paints a pose [P, 2 or 3] entirely in pale grey."""
        flat = points[:, :2]
        brush.taper(flat[-1], flat[self.wrist], 1.2 * FOREARM * self.unit, FOREARM * self.unit, GHOST)
        self._paint_palm(brush, flat, GHOST)
        for finger in self.fingers:
            self._paint_bones(brush, flat, finger, GHOST, 0.0)

    def _paint_palm(self, brush: Brush, flat: Floats, colour: Colour) -> None:
        """Paints the area between the wrist and the bases of the fingers."""
        bases = [flat[finger[0]] for finger in self.fingers]
        for base in bases:
            brush.taper(flat[self.wrist], base, 1.4 * PALM * self.unit, PALM * self.unit, colour)
        for first, second in combinations(bases, 2):
            brush.polygon(np.stack([flat[self.wrist], first, second]), colour)

    def _paint_finger(self, brush: Brush, flat: Floats, finger: tuple[int, ...], colour: Colour) -> None:
        self._paint_bones(brush, flat, finger, WHITE, CASING)
        self._paint_bones(brush, flat, finger, colour, 0.0)
        for joint in finger[:-1]:
            brush.disc(flat[joint], DOT * self.unit, WHITE)

    def _paint_bones(self, brush: Brush, flat: Floats, finger: tuple[int, ...], colour: Colour, casing: float) -> None:
        radii = (np.linspace(KNUCKLE, TIP, len(finger)) + casing) * self.unit
        for (start, stop), (first, last) in zip(pairwise(finger), pairwise(radii.tolist()), strict=True):
            brush.taper(flat[start], flat[stop], first, last, colour)
