"""The receivers of VMC and JSON Live Link that the settings name, and which connection sends to each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from motionsplice.motion.errors import MotionError
from motionsplice.runtime.requests import Poses
from motionsplice.sending.packing import Packer, packer
from motionsplice.sending.receiver import PORTS, Kind, Receiver
from motionsplice.service.characters.connection import Connection
from motionsplice.service.characters.play import Play
from motionsplice.service.metrics import Metrics
from motionsplice.service.problems import LimitError, RequestError
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings, variable

MOST: Mapping[Kind, int] = {"vmc": 1, "livelink": 32}  # characters; packing one takes 16 to 50 us of the event loop


@dataclass(eq=False)
class Output:
    """A receiver, and the connection that sends to it.

    Attributes:
        owner: The connection, or None.
        began: When its first frame was due, in seconds of the event loop's clock.
        edition: The edition for whose rig the packers are.
        packers: By the id of each character that was sent last.
        refused: Whether the owner knows that the system refused datagrams.
    """

    receiver: Receiver
    owner: Connection | None = None
    began: float = 0.0
    edition: Edition | None = None
    packers: dict[int, Packer] = field(default_factory=dict)
    refused: bool = False


class Receivers:
    """Sends characters to the receivers of the settings. Each takes those of one connection: the last that asked.

    Raises:
        SettingsError: Nothing can be sent to an address.
    """

    def __init__(self, settings: Settings, metrics: Metrics) -> None:
        self._outputs = {
            kind: Output(Receiver(address, PORTS[kind], variable(kind))) for kind, address in settings.receivers.items()
        }
        self._metrics = metrics

    @property
    def kinds(self) -> list[Kind]:
        """The kinds of receivers that there are."""
        return list(self._outputs)

    def check(self, play: Play) -> None:
        """Checks what a connection is to send. Raises RequestError or LimitError."""
        for kind, ids in play.scene.sent.items():
            if kind not in self._outputs:
                problem = f"to: this service has no receiver of {kind}"
                raise RequestError(problem, mend=f"Start it with --{kind} HOST:PORT")
            if len(ids) > MOST[kind]:
                problem = f"to: {kind} takes at most {MOST[kind]}, found {len(ids)} characters"
                raise LimitError(problem, mend="Send fewer")
            if play.ahead > 1:
                problem = f"ahead: {play.ahead} frames at once cannot be sent to {kind}"
                raise RequestError(problem, mend="Set ahead to 1")

    def claim(self, connection: Connection) -> None:
        """Gives a connection the receivers that its scene names, and takes them from others. It gives up the rest."""
        for kind, output in self._outputs.items():
            wants = kind in connection.play.scene.sent
            if wants and output.owner is not connection:
                self._end(kind, "another connection sends to it")
                output.owner, output.began, output.refused = connection, connection.play.due, False
            elif not wants and output.owner is connection:
                output.owner = None

    def release(self, connection: Connection) -> None:
        """Gives up all receivers of a connection that has ended."""
        for output in self._outputs.values():
            if output.owner is connection:
                output.owner = None

    def send(self, connection: Connection, poses: Poses) -> None:
        """Sends the characters that a connection's scene names, as `poses` has them at the frame that is due."""
        play = connection.play
        for kind, ids in play.scene.sent.items():
            output = self._outputs[kind]
            try:
                datagrams = self._datagrams(kind, output, play, poses, ids)
            except MotionError as error:
                self._end(kind, str(error))
                continue
            refused = output.receiver.send(datagrams)
            self._metrics.datagrams(kind, len(datagrams) - refused, refused)
            if refused and not output.refused:
                output.refused = True
                connection.queue_event("undelivered", to=kind, reason=output.receiver.reason)

    def _datagrams(
        self, kind: Kind, output: Output, play: Play, poses: Poses, ids: tuple[int, ...]
    ) -> list[bytes | memoryview]:
        """Returns the datagrams of a frame. Raises SkeletonError if the rig has too many joints."""
        edition = play.scene.edition
        known = output.packers if output.edition is edition else {}
        output.edition = edition
        output.packers = {one: known.get(one) or packer(kind, edition.bank, f"motionsplice-{one}") for one in ids}
        datagrams: list[bytes | memoryview] = []
        origins = play.scene.characters.origins
        for one, pack in output.packers.items():
            row = int(np.flatnonzero(play.scene.ids == one)[0])
            root = origins[row] + poses.root_positions[row]
            datagrams += pack.datagrams(play.due - output.began, root.astype(np.float32), poses.rotations[row])
        return datagrams

    def _end(self, kind: Kind, reason: str) -> None:
        """Ends what is sent to a receiver, and tells the connection that sent it."""
        output = self._outputs[kind]
        if output.owner is None:
            return
        scene = output.owner.play.scene
        ids = scene.sent[kind]
        scene.sent = {other: those for other, those in scene.sent.items() if other != kind}
        output.owner.queue_event("sending_ended", to=kind, ids=ids, reason=reason)
        output.owner = None
