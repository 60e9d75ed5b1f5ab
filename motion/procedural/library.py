"""The built-in motions by name: locomotions, and actions of the upper body on top of them.

They need no data. `make` performs any action on any locomotion, so each pair has a ground truth, which captured motion
rarely has.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.errors import SettingsError, did_you_mean
from motionsplice.motion.kinematics import local_rotations
from motionsplice.motion.procedural import actions, catalogue
from motionsplice.motion.procedural.body import ANKLE_HEIGHT, LEFT, RIGHT, SHANK, SKELETON, THIGH, euler, side_name
from motionsplice.motion.procedural.locomotions import varied
from motionsplice.motion.procedural.lower import lower_body
from motionsplice.motion.procedural.upper import Arm, Carriage, Rhythm, Trunk, swinging_arms, trunk
from motionsplice.motion.quaternion import Floats

LOCOMOTIONS: tuple[str, ...] = tuple(catalogue.LOCOMOTIONS)
ACTIONS: tuple[str, ...] = tuple(actions.ACTIONS)

# The place of a name seeds its random variation. Append new names, so that existing motions do not change.
_NUMBERS = (
    *("walk", "slow_walk", "curve", "run", "stairs_up", "side_step", "turn_180"),
    *("carry_box", "carry_cup", "punch", "push", "wave"),
    *("stairs_down", "walk_to_run", "step_up"),
)
_SHOULDERS_LEAD, _GAZE_LEADS = 0.12, 0.3  # seconds by which they turn ahead of the pelvis


def make(
    locomotion: str, action: str | None = None, *, seconds: float = 6.0, rate: float = 60.0, seed: int = 0
) -> Clip:
    """Generates a clip of a person on a locomotion, with or without an action.

    The root and the lower body depend on locomotion, seed, seconds and rate only. So the clip with an action is the
    ground truth of splicing that action onto the clip without it.

    Args:
        locomotion: One of LOCOMOTIONS.
        action: One of ACTIONS, or None to let the arms swing.
        seconds: Duration, up to 3600.
        rate: Frames per second, 1 to 1000.
        seed: Varies tempo, starting phase, stride and style.

    Returns:
        The clip, named after its locomotion and action, such as "walk+wave".

    Raises:
        SettingsError: A name is unknown, or seconds or rate are out of range.
    """
    known = catalogue.LOCOMOTIONS
    if locomotion not in known:
        raise SettingsError(f"unknown locomotion {locomotion!r}", mend=did_you_mean(locomotion, LOCOMOTIONS))
    if action is not None and action not in actions.ACTIONS:
        raise SettingsError(f"unknown action {action!r}", mend=did_you_mean(action, ACTIONS))
    if not (0.0 <= seconds <= 3600.0 and 1.0 <= rate <= 1000.0):
        raise SettingsError(
            f"cannot generate {seconds} seconds at {rate} frames per second",
            mend="Choose up to 3600 seconds at 1 to 1000 frames per second",
        )
    name = locomotion if action is None else f"{locomotion}+{action}"
    if action is None:
        return moving(name, locomotion, _swinging, seconds, rate, seed)
    own = np.random.default_rng([seed, _NUMBERS.index(action)])
    doing = actions.ACTIONS[action]
    return moving(name, locomotion, lambda carriage, rhythm: doing(carriage, rhythm, own), seconds, rate, seed)


def _swinging(carriage: Carriage, rhythm: Rhythm) -> actions.Upper:
    return trunk(carriage, rhythm), swinging_arms(carriage, rhythm)


def moving(
    name: str,
    locomotion: str,
    upper: Callable[[Carriage, Rhythm], actions.Upper],
    seconds: float,
    rate: float,
    seed: int,
) -> Clip:
    """Generates a clip of a person on a locomotion, whose upper body moves as `upper` returns."""
    random = np.random.default_rng([seed, _NUMBERS.index(locomotion)])
    chosen = varied(catalogue.LOCOMOTIONS[locomotion], random)
    walker = chosen.walker(seconds, start=random.uniform())
    time = np.arange(round(seconds * rate) + 1) / rate
    path, lower = walker.path, lower_body(walker, time)
    carriage = chosen.carriage(walker.tempo.weight(time))
    rhythm = Rhythm(
        phase=lower.phase,
        swing=lower.phase + carriage.lead,
        pace=path.pace(time),
        shoulders=path.heading(time + _SHOULDERS_LEAD),
        gaze=path.heading(time + _GAZE_LEADS),
        lean=path.lean(time),
        time=time,
    )
    world = lower.world | upper_body(lower.world["Hips"], rhythm, *upper(carriage, rhythm))
    return Clip(name, SKELETON, rate, lower.root, local_of(world))


def standing(
    name: str, upper: Callable[[Carriage, Rhythm], actions.Upper], seconds: float, rate: float, facing: float
) -> Clip:
    """Generates a clip of a person who stands, turned `facing` radians about Y; the upper body is as in `moving`."""
    time = np.arange(round(seconds * rate) + 1) / rate
    still = np.zeros(len(time))
    aside = np.radians(1.2) * np.sin(0.9 * time) * np.cos(0.37 * time + 1.0)  # nobody stands quite still
    heading = np.full(len(time), facing)
    rhythm = Rhythm(still, still, still, heading + aside, heading + 0.7 * aside, still, time)
    hips = euler(heading + 0.3 * aside, still, still)
    legs = [f"{side}{part}" for side in ("Left", "Right") for part in ("UpLeg", "Leg", "Foot", "ToeBase")]
    carriage = catalogue.LOCOMOTIONS["walk"].carriage(still)
    world = dict.fromkeys(["Hips", *legs], hips) | upper_body(hips, rhythm, *upper(carriage, rhythm))
    height = 0.03 + THIGH + SHANK + ANKLE_HEIGHT
    return Clip(name, SKELETON, rate, np.tile([0.0, height, 0.0], (len(time), 1)), local_of(world))


_SAMPLE_SEEDS = {name: seed for seed, name in enumerate(_NUMBERS, start=1)}


def sample_clips() -> dict[str, Clip]:
    """Returns the sample clips by name: all locomotions, and every action on a walk, each with its own seed."""
    plain = {name: make(name, seed=_SAMPLE_SEEDS[name]) for name in LOCOMOTIONS}
    return plain | {name: make("walk", name, seed=_SAMPLE_SEEDS[name]) for name in ACTIONS}


def truth(locomotion: str, action: str) -> Clip:
    """Returns the true result of splicing two sample clips: the action performed by the locomotion's person."""
    return make(locomotion, action, seed=_SAMPLE_SEEDS[locomotion])


def upper_body(hips: Floats, rhythm: Rhythm, chest: Trunk, arms: dict[float, Arm]) -> dict[str, Floats]:
    """Returns the world rotations [F, 4] of the upper body's joints by name."""
    shoulders = euler(rhythm.shoulders + chest.yaw, chest.pitch, chest.roll)
    gaze = euler(rhythm.gaze + 0.15 * chest.yaw + chest.glance, 0.3 * chest.pitch + 0.02 + chest.nod, 0.25 * chest.roll)
    world = {
        "Spine": quaternion.slerp(hips, shoulders, np.full(len(hips), 0.45)),
        "Spine1": quaternion.slerp(hips, shoulders, np.full(len(hips), 0.75)),
        "Spine2": shoulders,
        "Neck": quaternion.slerp(shoulders, gaze, np.full(len(hips), 0.45)),
        "Head": gaze,
    }
    for side in (LEFT, RIGHT):
        name, arm = side_name(side), arms[side]
        world[name + "Shoulder"] = shoulders
        world[name + "Arm"] = quaternion.multiply(shoulders, arm.upper)
        world[name + "ForeArm"] = quaternion.multiply(shoulders, arm.fore)
        world[name + "Hand"] = quaternion.multiply(shoulders, arm.hand)
    return world


def local_of(world: dict[str, Floats]) -> Floats:
    """Converts world rotations [F, 4] by joint name to rotations [F, J, 4] in the parents' frames."""
    return local_rotations(SKELETON, np.stack([world[name] for name in SKELETON.names], axis=1))
