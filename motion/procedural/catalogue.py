"""The built-in locomotions by name, with their parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from motionsplice.motion.procedural.curves import (
    RUN,
    RUN_FOOT,
    SIDE_STEP_FOOT,
    STAIRS_DOWN,
    STAIRS_DOWN_FOOT,
    STAIRS_UP,
    STAIRS_UP_FOOT,
    WALK,
    WALK_FOOT,
    scaled,
)
from motionsplice.motion.procedural.gait import Gait
from motionsplice.motion.procedural.locomotions import (
    Locomotion,
    Manner,
    around,
    around_a_step,
    leftward_steps,
    midway,
    onto_a_platform,
    there_and_back,
)
from motionsplice.motion.procedural.upper import Carriage

RISE, TREAD = 0.17, 0.29  # of a stair, metres
# In captured runs and jogs, arms and shoulders are 0.06 of a stride ahead of those in walks, relative to the knees. The
# knees of a run pass each other earlier after the heel strike by about as much again.
RUN_LEAD = 0.125


def _radians(**degrees: float) -> dict[str, float]:
    return {name: float(np.radians(angle)) for name, angle in degrees.items()}


_WALK = Manner(
    Gait(
        period=1.08,
        stride=1.31,
        duty=0.62,
        width=0.15,
        foot=WALK_FOOT,
        norm=WALK,
        sway=0.02,
        **_radians(pelvis_tilt=4, pelvis_list=4, pelvis_rotation=5),
    ),
    Carriage(
        **_radians(lean=3, twist=6, list=1.5, nod=1.2, swing=19, hang=-4, abduction=9, inward=12),
        **_radians(elbow=24, elbow_swing=9),
    ),
)
_SLOW_WALK = Manner(
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
    replace(_WALK.carriage, **_radians(lean=2, twist=4, swing=11, elbow=19, elbow_swing=5)),
)
_RUN = Manner(
    Gait(
        period=0.73,
        stride=2.15,
        duty=0.335,
        width=0.08,
        foot=RUN_FOOT,
        norm=RUN,
        sway=0.012,
        bob=0.042,
        toe_out=0.05,
        **_radians(pelvis_tilt=9, pelvis_list=4, pelvis_rotation=7),
    ),
    Carriage(
        **_radians(lean=9, twist=14, list=2, nod=1.5, swing=31, hang=-12, abduction=14, inward=26),
        **_radians(elbow=98, elbow_swing=12),
        lead=RUN_LEAD,
    ),
)
_STAIRS_UP = Manner(
    Gait(
        period=1.3,
        stride=2.0 * TREAD,
        duty=0.63,
        width=0.16,
        foot=STAIRS_UP_FOOT,
        norm=STAIRS_UP,
        rise=2.0 * RISE,
        lift=0.03,
        sway=0.028,
        **_radians(pelvis_tilt=10, pelvis_list=3.5, pelvis_rotation=4),
    ),
    replace(_WALK.carriage, **_radians(lean=12, twist=4, swing=14, hang=6, elbow=34)),
)
_STAIRS_DOWN = Manner(
    Gait(
        period=1.25,
        stride=2.0 * TREAD,
        duty=0.62,
        width=0.16,
        foot=STAIRS_DOWN_FOOT,
        norm=STAIRS_DOWN,
        rise=-2.0 * RISE,
        forefoot=1.0,
        sway=0.028,
        **_radians(pelvis_tilt=3, pelvis_list=4.5, pelvis_rotation=5),
    ),
    replace(_WALK.carriage, **_radians(lean=-1, twist=4, swing=12, hang=0, abduction=11, elbow=32)),
)
_SIDE_STEP = Manner(
    Gait(
        period=1.1,
        stride=0.52,
        duty=0.6,
        width=0.4,
        foot=SIDE_STEP_FOOT,
        norm=None,
        lift=0.045,
        lowered=0.05,
        bob=-0.012,
        sway=0.02,
        **_radians(pelvis_tilt=5, pelvis_list=2),
    ),
    replace(
        _WALK.carriage,
        **_radians(lean=6, twist=1.5, list=2.5, swing=4, hang=3, abduction=15, elbow=36, elbow_swing=4),
    ),
)
_STEPPING_UP = Manner(
    replace(
        _WALK.gait,
        period=1.3,
        stride=1.12,
        foot=scaled(WALK_FOOT, 0.75),
        norm=WALK,
        lift=0.04,
        rising=0.35,
        sway=0.026,
        **_radians(pelvis_tilt=10),
    ),
    replace(_WALK.carriage, **_radians(lean=17, swing=16, hang=5, elbow=32)),
)

LOCOMOTIONS: Mapping[str, Locomotion] = MappingProxyType(
    {
        "walk": Locomotion(_WALK),
        "slow_walk": Locomotion(_SLOW_WALK),
        "curve": Locomotion(replace(_WALK, gait=replace(_WALK.gait, period=1.12, stride=1.3)), route=around),
        "run": Locomotion(_RUN),
        "stairs_up": Locomotion(_STAIRS_UP),
        "side_step": Locomotion(_SIDE_STEP, route=leftward_steps),
        "turn_180": Locomotion(replace(_WALK, gait=replace(_WALK.gait, period=1.1, stride=1.3)), route=there_and_back),
        "stairs_down": Locomotion(_STAIRS_DOWN),
        "walk_to_run": Locomotion(_WALK, then=_RUN, changing=midway),
        "step_up": Locomotion(_WALK, then=_STEPPING_UP, changing=around_a_step, route=onto_a_platform),
    }
)
