"""A scene at one frame: what the clock of a connection moves on."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from motionsplice.service.characters.commands import Command
from motionsplice.service.characters.scene import Scene


class Play(NamedTuple):
    """A scene at one frame.

    Attributes:
        scene: The characters, as they are at this frame.
        frame: Number of the frame.
        due: When the frame is due, in seconds of the event loop's clock.
        rate: Frames per second.
        ahead: Frames in a message.
    """

    scene: Scene
    frame: int
    due: float
    rate: float
    ahead: int

    def after(self, count: int) -> Play:
        """Returns the play `count` frames later. The caller has advanced the scene by as many frames."""
        return Play(self.scene, self.frame + count, self.due + count / self.rate, self.rate, self.ahead)

    def done(self, commands: Iterable[Command], now: float) -> Play:
        """Does commands on the scene. Returns the play with the settings that they change."""
        play = self
        for command in commands:
            if command.do != "set":
                play.scene.do(command)
                continue
            rate, ahead = command.values.get("rate", play.rate), command.values.get("ahead", play.ahead)
            due = play.due if rate == play.rate else next_tick(now, rate)
            play = play._replace(rate=float(rate), ahead=ahead, due=due)
            play.scene.keep_time(play.rate)
            if "events" in command.values:
                play.scene.subscribe(command.values["events"])
        return play

    @property
    def load(self) -> float:
        """Characters evaluated per second."""
        return len(self.scene) * self.rate


def next_tick(now: float, rate: float) -> float:
    """Returns the next moment at which all connections of this rate have a frame."""
    return math.ceil(now * rate) / rate
