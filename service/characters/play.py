"""A scene at one frame: what the clock of a connection moves on."""

from __future__ import annotations

from typing import NamedTuple

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

    @property
    def load(self) -> float:
        """Characters evaluated per second."""
        return len(self.scene) * self.rate
