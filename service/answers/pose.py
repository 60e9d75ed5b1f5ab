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
from motionsplice.service.wire.encoding import Encoding
from motionsplice.service.wire.messages import FORMS, Form
from motionsplice.service.wire.parameters import HOW, WHAT, encoding, format_parameter, splice_of
from motionsplice.service.wire.query import REQUIRED, Query, number

POSE = Query(*WHAT, number("time", "seconds into the locomotion", REQUIRED), *HOW, format_parameter("json", "msgpack"))
TIME = b"time="
MOST_READY, LONGEST_READY = 1024, 512  # cached queries, and bytes of one


@dataclass(frozen=True, eq=False)
class Ready:
    """A parsed query without its time: the request, the memory for its pose, and the form of the answer."""

    requests: Requests
    poses: Poses
    encoding: Encoding
    form: Form


class PoseAnswers:
    """Answers queries for poses. The cache is emptied when the edition changes."""

    def __init__(self) -> None:
        self._edition: Edition | None = None
        self._ready: dict[bytes, Ready] = {}

    def answer(self, edition: Edition, query: bytes) -> Answer:
        """Returns the answer to a query. Raises MotionError."""
        if edition is not self._edition:
            self._edition, self._ready = edition, {}
        before, _, rest = query.partition(TIME)
        value, _, after = rest.partition(b"&")
        others = before + b"&" + after
        ready, time = self._ready.get(others), _seconds(value)
        if ready is None or time is None:
            values = POSE.read(query)
            time, ready = values["time"], _prepared(edition, values)
            if len(others) <= LONGEST_READY:
                if len(self._ready) >= MOST_READY:
                    self._ready.clear()
                self._ready[others] = ready
        ready.requests.time[0] = time
        edition.evaluator.evaluate(ready.requests, ready.poses)
        arrays = ready.encoding.arrays(edition.evaluator, ready.poses)
        body = ready.form.write(edition.bank.digest, {}, {name: one[0] for name, one in arrays.items()})
        return Answer(body, ready.form.media_type)


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
    return Ready(requests, evaluator.poses(1), encoding(values), FORMS[values["format"]])
