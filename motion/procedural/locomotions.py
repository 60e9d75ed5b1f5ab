"""The parts of a built-in locomotion: gaits, changes between them, routes, and its variation by seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from motionsplice.motion.procedural.body import HEEL, UP
from motionsplice.motion.procedural.gait import Gait
from motionsplice.motion.procedural.lower import LANDED, Walker
from motionsplice.motion.procedural.path import Path, about_turn, circle, ease, straight
from motionsplice.motion.procedural.tempo import Change, Tempo
from motionsplice.motion.procedural.turning import Turning
from motionsplice.motion.procedural.upper import Carriage
from motionsplice.motion.quaternion import Floats

STEP = 0.26  # the height of a platform, metres
_APPROACH, _ARRIVAL = 0.75, 0.5  # cycles of the second gait before and after a foot lands on the platform


@dataclass(frozen=True)
class Manner:
    """A gait, and the carriage of the upper body that goes with it."""

    gait: Gait
    carriage: Carriage


Route = Callable[[Turning, Tempo, float], Path]  # gait, tempo, seconds of the clip -> path
Changing = Callable[[float, float], Change]  # first phase of the clip, its strides at the first gait's tempo -> change


def never(start: float, strides: float) -> Change:
    """Keeps the first gait throughout."""
    return Change()


def midway(start: float, strides: float) -> Change:
    """Changes to the second gait within one and a half strides, beginning at two fifths of the clip."""
    return Change(start + 0.4 * strides, lasting=1.5)


def around_a_step(start: float, strides: float) -> Change:
    """Uses the second gait while both feet climb a platform, on which the first lands near the middle of the clip."""
    landing = round(2.0 * (start + 0.45 * strides)) / 2.0
    return Change(landing - _APPROACH, lasting=0.6, back=landing + _ARRIVAL)


def onward(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Leads straight ahead over a floor or stairs. The lowest foothold, the first or the last stair, is at Y = 0."""
    end = tempo.phase(np.array([seconds]))[0]
    lowest = -0.5 if gait.first.rise > 0.0 else np.floor(2.0 * (end - LANDED)) / 2.0 + 0.5
    below = gait.first.rise * (tempo.start - 0.5 * gait.first.duty - lowest)

    def position(time: Floats) -> Floats:
        phase = tempo.phase(time)
        up = below + tempo.along(gait.first.rise, gait.second.rise, phase)
        return np.stack([np.zeros_like(time), up, tempo.along(gait.first.stride, gait.second.stride, phase)], axis=-1)

    return straight(position)


def onto_a_platform(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Leads straight ahead and up one step."""
    flat = onward(gait, tempo, seconds).position
    landing = tempo.change.begin + _APPROACH
    foothold = flat(tempo.time(np.array([landing + 0.5 * gait.second.duty])))[0]
    edge = foothold[2] + HEEL[0] - 0.08

    def position(time: Floats) -> Floats:
        climbed = ease((tempo.phase(time) - landing) / 0.65)
        return flat(time) + STEP * climbed[:, None] * UP

    return straight(position, ground=lambda points: np.where(points[:, 2] > edge, STEP, 0.0))


def leftward_steps(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Leads to the left, facing ahead."""
    return straight(lambda time: np.multiply.outer(time, np.array([_speed(gait), 0.0, 0.0])))


def around(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Leads along a circle to the left."""
    return circle(_speed(gait), radius=2.6)


def there_and_back(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Leads ahead, turns round half-way through the clip, and leads back."""
    return about_turn(_speed(gait), middle=0.5 * seconds, lasting=1.5, slowest=0.25)


def _speed(gait: Turning) -> float:
    return gait.first.stride / gait.first.period


@dataclass(frozen=True)
class Locomotion:
    """A manner, a second manner and when it changes to it, and a route."""

    manner: Manner
    then: Manner | None = None
    changing: Changing = never
    route: Route = onward

    def walker(self, seconds: float, start: float) -> Walker:
        """Returns the walker of a clip of `seconds` that begins at phase `start`."""
        first = self.manner.gait
        second = first if self.then is None else self.then.gait
        tempo = Tempo(start, first.period, second.period, self.changing(start, seconds / first.period))
        gait = Turning(first, second)
        return Walker(gait, tempo, self.route(gait, tempo, seconds))

    def carriage(self, weight: Floats) -> Carriage:
        """Returns the carriage of the upper body where the second gait has weight `weight` [F]."""
        own = self.manner.carriage
        return own if self.then is None else own.turning_to(self.then.carriage, weight)


def varied(locomotion: Locomotion, random: np.random.Generator) -> Locomotion:
    """Returns the locomotion of a random person: tempo varies by 8 %, stride by 4 %, amplitudes by 12 %."""
    style, arms = random.uniform(0.88, 1.12, 2)
    stepping = 1.0 if locomotion.manner.gait.rise else random.uniform(0.96, 1.04)
    tempo = random.uniform(0.92, 1.08)

    def personal(manner: Manner) -> Manner:
        gait, carriage = manner.gait, manner.carriage
        return Manner(
            replace(
                gait,
                period=gait.period / tempo,
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

    then = None if locomotion.then is None else personal(locomotion.then)
    return replace(locomotion, manner=personal(locomotion.manner), then=then)
