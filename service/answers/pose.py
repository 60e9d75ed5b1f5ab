"""GET /v1/pose: one character at one moment."""

from __future__ import annotations

from service.answers.answer import Answer
from service.shared import Shared
from service.wire.messages import MEDIA_TYPES, json, packed
from service.wire.parameters import HOW, WHAT, encoding, format_parameter
from service.wire.query import REQUIRED, Query, number

POSE = Query(*WHAT, number("time", "seconds into the locomotion", REQUIRED), *HOW, format_parameter("json", "msgpack"))


def pose(shared: Shared, query: bytes) -> Answer:
    """The splice at one moment. Raises MotionError."""
    values = POSE.read(query)
    edition = shared.serving.edition
    poses = edition.evaluator.pose(
        values["locomotion"],
        values["time"],
        values["action"],
        start=values["start"],
        method=values["method"],
        posture=values["posture"],
    )
    arrays = encoding(values).arrays(edition.evaluator, poses)
    form = values["format"]
    write = json if form == "json" else packed
    body = write({"bank": edition.bank.digest}, {name: one[0] for name, one in arrays.items()})
    return Answer(body, MEDIA_TYPES[form].encode())
