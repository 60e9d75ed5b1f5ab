"""The operations of the direct route, which FastAPI does not know, from the lists that check their queries."""

from __future__ import annotations

from typing import Any

from motionsplice.service.answers.expectation import EXPECTATION
from motionsplice.service.answers.files import FILES
from motionsplice.service.answers.pose import POSE
from motionsplice.service.answers.poses import POSES
from motionsplice.service.answers.splice import SPLICE
from motionsplice.service.answers.stream import MEDIA_TYPE as STREAM_TYPE
from motionsplice.service.answers.stream import STREAM
from motionsplice.service.answers.take import TAKE
from motionsplice.service.openapi.schemas import Schema, reference
from motionsplice.service.routes import NOT_READY, OCTETS, REFUSED, UNKNOWN, Responses, problem_response
from motionsplice.service.wire.messages import JSON, MSGPACK
from motionsplice.service.wire.query import REQUIRED, Query

BUSY = problem_response(429, "Too many streams at once")
BODY: Responses = {
    **problem_response(408, "The body did not arrive"),
    **problem_response(413, "The body is too large"),
    **problem_response(415, "A body of an unsupported type"),
}
LIMITED = problem_response(422, "An invalid parameter, or more than the service allows")


def direct_operations(batch: dict[str, Any], order: dict[str, Any]) -> dict[str, Any]:
    """Returns the operations by path. `batch` and `order` are examples of a batch of poses and of a take."""
    return {
        "/v1/pose": {
            "get": _operation(
                "get_pose",
                "One pose",
                "The splice at one moment. It costs the same anywhere in a clip.",
                POSE,
                {MSGPACK: OCTETS, JSON: reference("Pose")},
                UNKNOWN,
                REFUSED,
                NOT_READY,
            )
        },
        "/v1/poses": {
            "post": {
                **_operation(
                    "post_poses",
                    "Poses of many characters",
                    "The request that a game sends every tick.",
                    POSES,
                    {MSGPACK: OCTETS, JSON: reference("Poses")},
                    UNKNOWN,
                    LIMITED,
                    NOT_READY,
                    BODY,
                ),
                "requestBody": {
                    "required": True,
                    "content": {
                        JSON: {"schema": reference("Batch"), "example": batch},
                        MSGPACK: {"schema": OCTETS},
                    },
                },
            }
        },
        "/v1/splice": {
            "get": _operation(
                "get_splice",
                "A whole splice",
                "All frames, or a range of them, in one cacheable answer.",
                SPLICE,
                {MSGPACK: OCTETS, **{form.decode(): OCTETS for form in FILES.values()}, JSON: reference("Frames")},
                UNKNOWN,
                LIMITED,
                BUSY,
                NOT_READY,
            )
        },
        "/v1/expectation": {
            "get": _operation(
                "get_expectation",
                "How far a splice can be trusted",
                "The error to expect of it, and of plain replacement, estimated from what both clips show.",
                EXPECTATION,
                {MSGPACK: OCTETS, JSON: reference("ExpectationAnswer")},
                UNKNOWN,
                REFUSED,
                BUSY,
                NOT_READY,
                answer="The estimate",
            )
        },
        "/v1/take": {
            "post": {
                **_operation(
                    "post_take",
                    "What a character does",
                    "All frames of a character that is given commands at certain frames, computed at once. With a "
                    "`rig`, also as the motion of its nodes, retargeted.",
                    TAKE,
                    {MSGPACK: OCTETS, **{form.decode(): OCTETS for form in FILES.values()}, JSON: reference("Take")},
                    UNKNOWN,
                    LIMITED,
                    BUSY,
                    NOT_READY,
                    BODY,
                ),
                "requestBody": {
                    "required": True,
                    "content": {JSON: {"schema": reference("TakeOrder"), "example": order}},
                },
            }
        },
        "/v1/stream": {
            "get": _operation(
                "get_stream",
                "A splice as a stream",
                "Length-delimited messages (four bytes, big-endian): a header, then maps of `ahead` frames each, in "
                "MessagePack.",
                STREAM,
                {STREAM_TYPE.decode(): OCTETS},
                UNKNOWN,
                LIMITED,
                BUSY,
                NOT_READY,
            )
        },
    }


def parameters(query: Query) -> list[dict[str, Any]]:
    """Returns the parameters of a query."""
    return [
        {
            "name": one.name,
            "in": "query",
            "required": one.default is REQUIRED,
            "description": one.description[0].upper() + one.description[1:],
            "schema": dict(one.schema),
        }
        for one in query.parameters.values()
    ]


def _operation(
    name: str,
    summary: str,
    description: str,
    query: Query,
    content: dict[str, Schema],
    *problems: Responses,
    answer: str = "The frames",
) -> dict[str, Any]:
    """Returns an operation whose answer is of one of several media types.

    Binary types come first: generated clients that parse only one of them take the first, and bytes can hold JSON.
    """
    frames = {media_type: {"schema": schema} for media_type, schema in content.items()}
    return {
        "tags": ["motion"],
        "summary": summary,
        "description": description,
        "operationId": name,
        "parameters": parameters(query),
        "responses": {
            "200": {"description": answer, "content": frames},
            **{str(status): response for one in problems for status, response in one.items()},
        },
    }
