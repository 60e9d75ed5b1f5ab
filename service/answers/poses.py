"""POST /v1/poses: many characters at one moment, the call that a game makes once a tick."""

from __future__ import annotations

from time import perf_counter

from starlette.types import Receive, Scope

from motionsplice.service.answers.answer import Answer
from motionsplice.service.answers.batch import Batch
from motionsplice.service.answers.body import header, whole_body
from motionsplice.service.problems import LimitError, MediaTypeError
from motionsplice.service.shared import Shared
from motionsplice.service.wire.messages import FORMS, JSON, MSGPACK
from motionsplice.service.wire.parameters import HOW, encoding, format_parameter
from motionsplice.service.wire.query import Query

POSES = Query(*HOW, format_parameter("json", "msgpack"))
JSON_SHARE = 16  # JSON in memory is so many times larger and slower than blobs, so there must be less of it


async def poses(shared: Shared, scope: Scope, receive: Receive) -> Answer:
    """The poses of all characters of a batch. Raises MotionError."""
    values, settings = POSES.read(scope["query_string"]), shared.settings
    given = header(scope, b"content-type").partition(";")[0].strip().lower()
    if given not in (JSON, MSGPACK):
        raise MediaTypeError(f"a body of type {given!r:.80} is not read", mend=f"Send {MSGPACK} or {JSON}")
    most = settings.max_body // (JSON_SHARE if given == JSON else 1)
    body = await whole_body(scope, receive, most, settings.request_seconds)
    read = Batch.from_json if given == JSON else Batch.from_msgpack
    batch = read(body, settings.max_batch)
    edition, form, count = shared.serving.edition, values["format"], len(batch.columns["locomotion"])
    if form == "json" and count > (fewer := settings.max_batch // JSON_SHARE):
        raise LimitError(
            f"{count} characters are more than the {fewer} that JSON is for", mend="Ask for format=msgpack"
        )
    requests = batch.requests(edition.bank)
    out, began = edition.evaluator.poses(len(requests)), perf_counter()
    edition.evaluator.evaluate(requests, out)
    shared.metrics.evaluation.observe(perf_counter() - began)
    arrays = encoding(values).arrays(edition.evaluator, out)
    media_type, write = FORMS[form]
    return Answer(write({"bank": edition.bank.digest}, arrays), media_type)
