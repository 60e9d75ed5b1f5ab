"""What a built-in locomotion is made of, how seeds vary it, and where and when it leads."""

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
_APPROACH, _ARRIVAL = 0.75, 0.5  # cycles before a foot lands on the platform, and after, of another gait


@dataclass(frozen=True)
class Manner:
    """A gait, and how it carries the upper body."""

    gait: Gait
    carriage: Carriage


Route = Callable[[Turning, Tempo, float], Path]  # of a gait, its tempo and a clip's seconds
Changing = Callable[[float, float], Change]  # of a clip's first phase, and its strides at the first gait's tempo


def never(start: float, strides: float) -> Change:
    """One gait all the way."""
    return Change()


def midway(start: float, strides: float) -> Change:
    """Into the second gait within one and a half strides, from two fifths of the clip on."""
    return Change(start + 0.4 * strides, lasting=1.5)


def around_a_step(start: float, strides: float) -> Change:
    """The second gait while both feet climb a platform: the first lands there near the middle of the clip."""
    landing = round(2.0 * (start + 0.45 * strides)) / 2.0
    return Change(landing - _APPROACH, lasting=0.6, back=landing + _ARRIVAL)


def onward(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Straight ahead over a floor or stairs. No foot stands lower than Y = 0, where the first or the last stair is."""
    end = tempo.phase(np.array([seconds]))[0]
    lowest = -0.5 if gait.first.rise > 0.0 else np.floor(2.0 * (end - LANDED)) / 2.0 + 0.5
    below = gait.first.rise * (tempo.start - 0.5 * gait.first.duty - lowest)

    def position(time: Floats) -> Floats:
        phase = tempo.phase(time)
        up = below + tempo.along(gait.first.rise, gait.second.rise, phase)
        return np.stack([np.zeros_like(time), up, tempo.along(gait.first.stride, gait.second.stride, phase)], axis=-1)

    return straight(position)


def onto_a_platform(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Straight ahead, and up one step."""
    flat = onward(gait, tempo, seconds).position
    landing = tempo.change.begin + _APPROACH
    foothold = flat(tempo.time(np.array([landing + 0.5 * gait.second.duty])))[0]
    edge = foothold[2] + HEEL[0] - 0.08

    def position(time: Floats) -> Floats:
        climbed = ease((tempo.phase(time) - landing) / 0.65)
        return flat(time) + STEP * climbed[:, None] * UP

    return straight(position, ground=lambda points: np.where(points[:, 2] > edge, STEP, 0.0))


def leftward_steps(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """To the left, facing ahead."""
    return straight(lambda time: np.multiply.outer(time, np.array([_speed(gait), 0.0, 0.0])))


def around(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Along a circle to the left."""
    return circle(_speed(gait), radius=2.6)


def there_and_back(gait: Turning, tempo: Tempo, seconds: float) -> Path:
    """Ahead, about half way through the clip, and back."""
    return about_turn(_speed(gait), middle=0.5 * seconds, lasting=1.5, slowest=0.25)


def _speed(gait: Turning) -> float:
    return gait.first.stride / gait.first.period


@dataclass(frozen=True)
class Locomotion:
    """A manner, another that it changes to if `changing` says so, and where they lead."""

    manner: Manner
    then: Manner | None = None
    changing: Changing = never
    route: Route = onward

    def walker(self, seconds: float, start: float) -> Walker:
        """Who begins a clip of `seconds` at phase `start`."""
        first = self.manner.gait
        second = first if self.then is None else self.then.gait
        tempo = Tempo(start, first.period, second.period, self.changing(start, seconds / first.period))
        gait = Turning(first, second)
        return Walker(gait, tempo, self.route(gait, tempo, seconds))

    def carriage(self, weight: Floats) -> Carriage:
        """How the upper body is carried where the first gait has given way by `weight` [F]."""
        own = self.manner.carriage
        return own if self.then is None else own.turning_to(self.then.carriage, weight)


def varied(locomotion: Locomotion, random: np.random.Generator) -> Locomotion:
    """The same locomotion of another person: tempo within 8 %, stride within 4 %, amplitudes within 12 %."""
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
