"""POST /v1/poses: many characters at one moment, the request that a game sends every tick."""

from __future__ import annotations

from time import perf_counter

from starlette.types import Receive, Scope

from motionsplice.service.answers.answer import Answer
from motionsplice.service.answers.batch import Batch
from motionsplice.service.answers.body import media_type, whole_body
from motionsplice.service.problems import LimitError
from motionsplice.service.shared import Shared
from motionsplice.service.wire.messages import FORMS, JSON, JSON_SHARE, MSGPACK
from motionsplice.service.wire.parameters import HOW, encoding, format_parameter
from motionsplice.service.wire.query import Query

POSES = Query(*HOW, format_parameter("json", "msgpack"))


async def poses(shared: Shared, scope: Scope, receive: Receive) -> Answer:
    """Returns the poses of all characters of a batch. Raises MotionError."""
    values, settings = POSES.read(scope["query_string"]), shared.settings
    is_json = media_type(scope, MSGPACK, JSON) == JSON
    most = settings.max_body // (JSON_SHARE if is_json else 1)
    body = await whole_body(scope, receive, most, settings.request_seconds)
    read = Batch.from_json if is_json else Batch.from_msgpack
    batch = read(body, settings.max_batch)
    edition, form, count = shared.serving.edition, values["format"], len(batch.columns["locomotion"])
    if form == "json" and count > (fewer := settings.max_batch // JSON_SHARE):
        raise LimitError(
            f"{count} characters are more than the limit of {fewer} for JSON", mend="Ask for format=msgpack"
        )
    requests = batch.requests(edition.bank)
    out, began = edition.evaluator.poses(len(requests)), perf_counter()
    edition.evaluator.evaluate(requests, out)
    shared.metrics.evaluation.observe(perf_counter() - began)
    arrays = encoding(values).arrays(edition.evaluator, out)
    answer_type, write = FORMS[form]
    return Answer(write(edition.bank.digest, {}, arrays), answer_type)
