"""The numbers of each built-in locomotion, and how seeds vary them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from motion.procedural.curves import (
    RUN,
    RUN_FOOT,
    SIDE_STEP_FOOT,
    STAIRS_UP,
    STAIRS_UP_FOOT,
    WALK,
    WALK_FOOT,
    scaled,
)
from motion.procedural.gait import Gait
from motion.procedural.path import Path, about_turn, circle, straight
from motion.procedural.upper import Carriage

RISE, TREAD = 0.17, 0.29  # of a stair, metres


@dataclass(frozen=True)
class Locomotion:
    """A gait, and how it carries the upper body."""

    gait: Gait
    carriage: Carriage


_WALK = Locomotion(
    Gait(
        period=1.08,
        stride=1.31,
        duty=0.62,
        width=0.15,
        foot=WALK_FOOT,
        norm=WALK,
        pelvis_tilt=np.radians(4.0),
        pelvis_list=np.radians(4.0),
        pelvis_rotation=np.radians(5.0),
        sway=0.02,
    ),
    Carriage(
        lean=np.radians(3.0),
        twist=np.radians(6.0),
        list=np.radians(1.5),
        nod=np.radians(1.2),
        swing=np.radians(19.0),
        hang=np.radians(-4.0),
        abduction=np.radians(9.0),
        inward=np.radians(12.0),
        elbow=np.radians(24.0),
        elbow_swing=np.radians(9.0),
    ),
)

LOCOMOTIONS: Mapping[str, Locomotion] = MappingProxyType(
    {
        "walk": _WALK,
        "slow_walk": Locomotion(
            replace(
                _WALK.gait,
                period=1.42,
                stride=1.12,
                width=0.17,
                sway=0.03,
                lift=0.012,
                norm=WALK.scaled(0.9),
                foot=scaled(WALK_FOOT, 0.85),
            ),
            replace(
                _WALK.carriage,
                lean=np.radians(2.0),
                twist=np.radians(4.0),
                swing=np.radians(11.0),
                elbow=np.radians(19.0),
                elbow_swing=np.radians(5.0),
            ),
        ),
        "curve": Locomotion(replace(_WALK.gait, period=1.12, stride=1.3), _WALK.carriage),
        "run": Locomotion(
            Gait(
                period=0.73,
                stride=2.15,
                duty=0.335,
                width=0.08,
                foot=RUN_FOOT,
                norm=RUN,
                pelvis_tilt=np.radians(9.0),
                pelvis_list=np.radians(4.0),
                pelvis_rotation=np.radians(7.0),
                sway=0.012,
                bob=0.042,
                toe_out=0.05,
            ),
            Carriage(
                lean=np.radians(9.0),
                twist=np.radians(14.0),
                list=np.radians(2.0),
                nod=np.radians(1.5),
                swing=np.radians(31.0),
                hang=np.radians(-12.0),
                abduction=np.radians(14.0),
                inward=np.radians(26.0),
                elbow=np.radians(98.0),
                elbow_swing=np.radians(12.0),
            ),
        ),
        "stairs_up": Locomotion(
            Gait(
                period=1.3,
                stride=2.0 * TREAD,
                duty=0.63,
                width=0.16,
                foot=STAIRS_UP_FOOT,
                norm=STAIRS_UP,
                rise=2.0 * RISE,
                lift=0.03,
                pelvis_tilt=np.radians(10.0),
                pelvis_list=np.radians(3.5),
                pelvis_rotation=np.radians(4.0),
                sway=0.028,
            ),
            replace(
                _WALK.carriage,
                lean=np.radians(12.0),
                twist=np.radians(4.0),
                swing=np.radians(14.0),
                hang=np.radians(6.0),
                elbow=np.radians(34.0),
            ),
        ),
        "side_step": Locomotion(
            Gait(
                period=1.1,
                stride=0.52,
                duty=0.6,
                width=0.4,
                foot=SIDE_STEP_FOOT,
                lift=0.045,
                lowered=0.05,
                bob=-0.012,
                pelvis_tilt=np.radians(5.0),
                pelvis_list=np.radians(2.0),
                sway=0.02,
            ),
            replace(
                _WALK.carriage,
                lean=np.radians(6.0),
                twist=np.radians(1.5),
                list=np.radians(2.5),
                swing=np.radians(4.0),
                hang=np.radians(3.0),
                abduction=np.radians(15.0),
                elbow=np.radians(36.0),
                elbow_swing=np.radians(4.0),
            ),
        ),
        "turn_180": Locomotion(replace(_WALK.gait, period=1.1, stride=1.3), _WALK.carriage),
    }
)


def varied(locomotion: Locomotion, random: np.random.Generator) -> Locomotion:
    """The same locomotion of another person: tempo within 8 %, stride within 4 %, amplitudes within 12 %."""
    gait, carriage = locomotion.gait, locomotion.carriage
    style, arms = random.uniform(0.88, 1.12, 2)
    stepping = 1.0 if gait.rise else random.uniform(0.96, 1.04)
    return Locomotion(
        replace(
            gait,
            period=gait.period / random.uniform(0.92, 1.08),
            stride=gait.stride * stepping,
            pelvis_list=gait.pelvis_list * style,
            pelvis_rotation=gait.pelvis_rotation * style,
            sway=gait.sway * style,
        ),
        replace(
            carriage,
            twist=carriage.twist * style,
            swing=carriage.swing * arms,
            elbow=carriage.elbow * arms,
            elbow_swing=carriage.elbow_swing * arms,
        ),
    )


def path_of(name: str, gait: Gait, seconds: float, start: float) -> Path:
    """Where a locomotion that begins at phase `start` leads; an about-turn is half way through the clip."""
    speed = gait.stride / gait.period
    if name == "curve":
        return circle(speed, radius=2.6)
    if name == "turn_180":
        return about_turn(speed, middle=0.5 * seconds, lasting=1.5, slowest=0.25)
    if name == "side_step":
        return straight((speed, 0.0, 0.0))
    # No foot stands lower than Y = 0: the left one is then on the stair above.
    below = gait.rise * (start - 0.5 * gait.duty + 0.5)
    return straight((0.0, gait.rise / gait.period, speed), (0.0, below, 0.0))
