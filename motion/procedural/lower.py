"""The lower body: feet planned on the ground, the pelvis over them, and legs solved between the two.

A foot in swing follows its gait. A foot in stance stays on its foothold and rolls over heel and ball. So knees and hips
follow the norms, and no foot slides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from motionsplice.motion import quaternion
from motionsplice.motion.procedural.body import (
    ANKLE_HEIGHT,
    LEFT,
    RIGHT,
    SHANK,
    THIGH,
    UP,
    euler,
    frame,
    side_name,
    two_bones,
)
from motionsplice.motion.procedural.gait import LONGEST, TURN, harmonics, hip_of, progress, rocker
from motionsplice.motion.procedural.path import Path, ease, forward, leftward
from motionsplice.motion.procedural.tempo import Tempo
from motionsplice.motion.procedural.turning import Turning
from motionsplice.motion.quaternion import Floats

LEAVE, LAND = 0.12, 0.1  # cycles over which a foot blends from stance to swing, and back
# A foothold uses the gait at this phase of its foot, shortly before the foot leaves. With the gait at landing, a body
# that speeds up would outrun the leg.
TO_LEAVE = 0.4
LANDED = 0.07  # the phase at which a foot has come to rest after heel strike


@dataclass(frozen=True)
class Walker:
    """A gait, the tempo of its steps, and the path along which they lead."""

    gait: Turning
    tempo: Tempo
    path: Path


@dataclass(frozen=True)
class Foot:
    """A foot over F frames: the ankle's position [F, 3], yaw and pitch of the foot [F], and bend of the toes [F]."""

    ankle: Floats
    yaw: Floats
    pitch: Floats
    toes: Floats


def foot(walker: Walker, side: float, time: Floats) -> Foot:
    """Returns the motion of one foot at times [F] seconds."""
    gait, tempo, path = walker.gait, walker.tempo, walker.path
    behind = 0.0 if side == LEFT else 0.5
    phase = tempo.phase(time) + behind
    cycle = np.floor(phase - LANDED)
    first = int(cycle.min())
    landing_at = np.arange(first, int(cycle.max()) + 2, dtype=np.float64) - behind
    weights = tempo.change.weight(landing_at + TO_LEAVE)  # one for each foothold: a standing foot does not change
    duties = gait.value("duty", weights)
    at = tempo.time(landing_at + 0.5 * duties)
    yaw = path.heading(at)
    place = path.position(at) + leftward(yaw) * (0.5 * side * gait.value("width", weights)[:, None])
    place[:, 1] = path.ground(place)
    yaw = yaw + side * gait.value("toe_out", weights)
    pace = path.pace(at)
    index = cycle.astype(np.int64) - first
    u, duty = phase - cycle, duties[index]
    s = np.clip((u - duty) / (1.0 - duty), 0.0, 1.0)
    eased = progress(u, duty)

    def between(values: Floats) -> Floats:
        return values[index] + (values[index + 1] - values[index]) * eased

    weight = between(weights)
    pitch = gait.foot(u, weight) * between(pace)
    foot_yaw = between(yaw)
    # In swing the foot follows the norm; just after leaving and just before landing it rolls on the ground.
    leaving = 1.0 - ease((u - duty) / LEAVE + 0.35)
    landing = ease((u - 1.0 - LANDED) / LAND + 1.0)
    rolled = np.stack(rocker(pitch), axis=-1)
    stepping = between(pace)
    moved = gait.swing(np.maximum(u, 0.5 * duty), weight) * np.stack([stepping, 0.4 + 0.6 * stepping], axis=-1)
    rising = ease(s / gait.value("rising", weights)[index])
    climbed = (place[index + 1] - place[index])[:, 1] - gait.value("rise", weight)
    moved[:, 1] += climbed * (rising - eased)

    def on(ground: Floats, direction: Floats, offset: Floats) -> Floats:
        return ground + direction * offset[:, :1] + UP * (ANKLE_HEIGHT + offset[:, 1:])

    left, next_to = place[index], place[index + 1]
    ankle = (
        on(left, forward(yaw[index]), rolled) * leaving[:, None]
        + on(left + (next_to - left) * eased[:, None], forward(foot_yaw), moved) * (1.0 - leaving - landing)[:, None]
        + on(next_to, forward(yaw[index + 1]), rolled) * landing[:, None]
    )
    level = np.maximum(1.0 - ease(s / 0.45), landing * gait.value("forefoot", weight))
    return Foot(ankle, foot_yaw, pitch, np.maximum(-pitch, 0.0) * level)


@dataclass(frozen=True)
class LowerBody:
    """Root positions [F, 3], world rotations [F, 4] by joint name, and the phase [F] of the left foot."""

    root: Floats
    world: dict[str, Floats]
    phase: Floats


def lower_body(walker: Walker, time: Floats) -> LowerBody:
    """Returns the lower body at times [F] seconds."""
    root, pelvis, feet = _planned(walker, time)
    root = root - UP * _sink(walker, time)[:, None]
    phase = walker.tempo.phase(time)
    heading = walker.path.heading(time) + walker.gait.pelvis_turn(phase, walker.tempo.weight(time))[0]
    world = {"Hips": pelvis}
    for side, planned in feet.items():
        name = side_name(side)
        hip = root + quaternion.rotate(pelvis, hip_of(side))
        pole = forward(0.5 * (heading + planned.yaw))
        leg = two_bones(planned.ankle - hip, pole, THIGH, SHANK)
        ankle = euler(planned.yaw, -planned.pitch, 0.0)
        world[name + "UpLeg"] = frame(leg.hinge, -leg.upper)
        world[name + "Leg"] = frame(leg.hinge, -leg.lower)
        world[name + "Foot"] = ankle
        world[name + "ToeBase"] = quaternion.multiply(ankle, quaternion.about([1.0, 0.0, 0.0], -planned.toes))
    return LowerBody(root, world, phase)


def _planned(walker: Walker, time: Floats) -> tuple[Floats, Floats, dict[float, Foot]]:
    """Returns root positions [F, 3], pelvis rotations [F, 4] and feet, whether or not the legs can reach."""
    gait, path, phase, weight = walker.gait, walker.path, walker.tempo.phase(time), walker.tempo.weight(time)
    heading, pace, rolled = path.heading(time), path.pace(time), path.lean(time)
    yaw, pitch, roll = gait.pelvis_turn(phase, weight)
    pelvis = euler(heading + yaw * pace, pitch, roll * pace - 0.5 * rolled)
    waves = harmonics(phase)
    surge = np.sum(waves * gait.surge(weight), axis=-1) * pace
    waves[:, 1:] *= (pace**2)[:, None]
    height = np.sum(waves * gait.height(weight), axis=-1)
    swaying = np.cos(TURN * (phase - 0.5 * gait.value("duty", weight)))
    aside = gait.value("sway", weight) * swaying + 0.5 * np.tan(rolled)
    root = path.position(time) + forward(heading) * surge[:, None] + leftward(heading) * aside[:, None]
    return root + UP * height[:, None], pelvis, {side: foot(walker, side, time) for side in (LEFT, RIGHT)}


def _sink(walker: Walker, time: Floats) -> Floats:
    """Returns how far [F] the hips must sink, smoothly, so that no leg reaches further than `LONGEST`.

    It is computed on a fixed time grid that extends beyond both ends, so that it depends neither on the rate nor on
    where the clip ends.
    """
    rate, radius = 100.0, 10
    margin = 2.0 * radius / rate
    grid = np.arange(time[0] - margin, time[-1] + margin + 2.0 / rate, 1.0 / rate)
    root, pelvis, feet = _planned(walker, grid)
    excess = np.zeros(len(grid))
    for side, planned in feet.items():
        leg = root + quaternion.rotate(pelvis, hip_of(side)) - planned.ankle
        tallest = np.sqrt(np.maximum(LONGEST**2 - leg[:, 0] ** 2 - leg[:, 2] ** 2, 0.01))
        excess = np.maximum(excess, leg[:, 1] - tallest)
    # The blur is no wider than the window of the maximum, so the result is nowhere below the excess.
    return CubicSpline(grid, gaussian_filter1d(maximum_filter1d(excess, 2 * radius + 1), radius / 3, radius=radius))(
        time
    )
