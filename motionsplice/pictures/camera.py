"""A camera that follows a character, and motions projected into its view at given times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from motionsplice.motion.clip import Clip
from motionsplice.motion.kinematics import hips_heading, joint_positions
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import Roles
from motionsplice.pictures.hand_figure import HandFigure
from motionsplice.pictures.stick_figure import StickFigure

Figure = StickFigure | HandFigure

# Degrees from the character's front towards its right, and degrees above the floor.
VIEWS = {"side": (90.0, 6.0), "front": (0.0, 6.0), "three-quarter": (45.0, 10.0)}
TRACKING_RATE = 30.0  # frames per second at most of what the camera follows
SMOOTHING = 0.5  # seconds, standard deviation
MARK_SPACING = 0.4  # metres
REACH = 3  # marks on each side of a figure


@dataclass(frozen=True, eq=False)
class Camera:
    """The orientation of a camera at each of n times, and the floor.

    axes:   [n, 3, 3] rows are the directions to the right, up and towards the viewer, in the world.
    ground: height of the floor in metres: the lowest point of the feet.
    """

    axes: Floats
    ground: float

    @classmethod
    def beside(cls, clip: Clip, roles: Roles, times: Floats, view: str) -> Camera:
        """Returns the camera that stays on one side of a character at `times` [n] seconds; `view` is one of VIEWS.

        It turns with the heading of the hips, smoothed over about a second, so that the side view of a walk along a
        curve looks like that of a straight walk.
        """
        tracked = clip.resampled(min(TRACKING_RATE, clip.rate))
        positions = joint_positions(tracked)
        headings = np.unwrap(hips_heading(positions, roles))
        headings = gaussian_filter1d(headings, SMOOTHING * tracked.rate, mode="nearest")
        clock = np.arange(tracked.frame_count) / tracked.rate
        first, last = np.searchsorted(clock, [times[0], times[-1]])
        first = min(first, tracked.frame_count - 1)
        feet = positions[:, clip.skeleton.subtree(roles.left_ankle) + clip.skeleton.subtree(roles.right_ankle)]
        around, above = np.radians(VIEWS[view])
        yaw = np.interp(times, clock, headings) - around
        x, z, still = np.sin(yaw), np.cos(yaw), np.zeros(len(times))
        right = np.stack([z, still, -x], axis=-1)
        towards = np.stack([x * np.cos(above), still + np.sin(above), z * np.cos(above)], axis=-1)
        return cls(
            np.stack([right, np.cross(towards, right), towards], axis=1), float(feet[first : last + 1, :, 1].min())
        )

    def sees(self, points: Floats, middles: Floats) -> Floats:
        """Projects world points [n, P, 3] around `middles` [n, 3] -> [n, P, 3] right, up, towards the viewer."""
        return np.asarray((points - middles[:, None]) @ np.swapaxes(self.axes, 1, 2))


@dataclass(frozen=True, eq=False)
class Take:
    """One motion in the view of a camera, in metres: to the right, up and towards the viewer of the figure's middle.

    points: [n, P, 3] the figure's points.
    floor:  [n, M, 3] marks on the floor, fixed in the world.
    held:   [n] whether the motion has ended, so that its last frame is held.
    """

    figure: Figure
    points: Floats
    floor: Floats
    held: tuple[bool, ...]

    @classmethod
    def of(cls, clip: Clip, figure: Figure, times: Floats, camera: Camera) -> Take:
        """Returns `clip` as `camera` sees it at `times` [n] seconds, with the floor marks around it."""
        roots, rotations = clip.sampled(times * clip.rate)
        steps = MARK_SPACING * np.arange(-REACH, REACH + 1)
        around = np.stack(np.meshgrid(steps, [0.0], steps), axis=-1).reshape(-1, 3)
        marks = np.round(roots / MARK_SPACING)[:, None] * MARK_SPACING + around
        marks[..., 1] = camera.ground
        held = tuple(bool(time > clip.duration + 1e-6) for time in times)
        points = figure.points(roots, rotations)
        middles = figure.middles(points, camera.ground)
        return cls(figure, camera.sees(points, middles), camera.sees(marks, middles), held)
