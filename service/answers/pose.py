"""GET /v1/pose: one character at one moment.

Games request the same splice again and again, at other times. So everything in a query but its time is parsed once
and cached.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from motionsplice.runtime.requests import Poses, Requests
from motionsplice.service.answers.answer import Answer
from motionsplice.service.serving import Edition
from motionsplice.service.wire.encoding import Arrays, Encoding
from motionsplice.service.wire.messages import FORMS, Form, pieces
from motionsplice.service.wire.parameters import HOW, WHAT_AT_A_MOMENT, encoding, format_parameter, splice_of
from motionsplice.service.wire.query import REQUIRED, Query, number

SECONDS = number("time", "seconds into the locomotion", REQUIRED)
POSE = Query(*WHAT_AT_A_MOMENT, SECONDS, *HOW, format_parameter("json", "msgpack"))
TIME = b"time="
MOST_READY, LONGEST_READY = 1024, 512  # cached queries, and bytes of one


@dataclass(frozen=True, eq=False)
class Ready:
    """A parsed query without its time: the request, the memory for its pose, and the form of the answer.

    Attributes:
        pieces: The pieces of the answer, if the pose itself is among them.
    """

    requests: Requests
    poses: Poses
    encoding: Encoding
    form: Form
    pieces: list[Any] | None

    def answer(self, edition: Edition, time: float) -> Answer:
        """Returns the pose at a time, in seconds. Raises MotionError."""
        self.requests.time[0] = time
        edition.evaluator.evaluate(self.requests, self.poses)
        if self.pieces is not None:
            body = b"".join(self.pieces)
        else:
            body = self.form.write(edition.bank.digest, {}, _arrays(edition, self.encoding, self.poses))
        return Answer(body, self.form.media_type)


class PoseAnswers:
    """Answers queries for poses. The cache is emptied when the edition changes."""

    def __init__(self) -> None:
        self._edition: Edition | None = None
        self._ready: dict[bytes, Ready] = {}

    def answer(self, edition: Edition, query: bytes) -> Answer:
        """Returns the answer to a query. Raises MotionError."""
        if (answer := self.known(edition, query)) is not None:
            return answer
        values, (others, _) = POSE.read(query), _parts(query)
        ready = _prepared(edition, values)
        if len(others) <= LONGEST_READY:
            if len(self._ready) >= MOST_READY:
                self._ready.clear()
            self._ready[others] = ready
        return ready.answer(edition, values["time"])

    def known(self, edition: Edition, query: bytes) -> Answer | None:
        """Returns the answer to a query that differs from an earlier one only in its time, else None.

        Raises MotionError.
        """
        if edition is not self._edition:
            self._edition, self._ready = edition, {}
        others, value = _parts(query)
        ready, time = self._ready.get(others), _seconds(value)
        return None if ready is None or time is None else ready.answer(edition, time)


def _parts(query: bytes) -> tuple[bytes, bytes]:
    """Returns a query without its time, and the time."""
    before, _, rest = query.partition(TIME)
    value, _, after = rest.partition(b"&")
    return before + b"&" + after, value


def _seconds(value: bytes) -> float | None:
    """Returns a plain number of seconds, or None for anything else, which `Query.read` reports."""
    try:
        seconds = float(value)
    except ValueError:
        return None
    return seconds if 0.0 <= seconds < math.inf else None


def _prepared(edition: Edition, values: dict[str, Any]) -> Ready:
    evaluator, requests = edition.evaluator, Requests.empty(1)
    requests.records[0] = evaluator.record(splice_of(values))
    poses, how, form = evaluator.poses(1), encoding(values), FORMS[values["format"]]
    is_constant = how.is_in_place and values["format"] == "msgpack"
    constant = pieces(edition.bank.digest, {}, _arrays(edition, how, poses)) if is_constant else None
    return Ready(requests, poses, how, form, constant)


def _arrays(edition: Edition, how: Encoding, poses: Poses) -> Arrays:
    return {name: one[0] for name, one in how.arrays(edition.evaluator, poses).items()}
