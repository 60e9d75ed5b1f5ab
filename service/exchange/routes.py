"""Routes for uploading clips, and for following the offline job."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Annotated, Literal

import orjson
from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import StreamingResponse

from motionsplice.service.answers.body import steady_chunks
from motionsplice.service.exchange.clip_entries import EntryUpdate
from motionsplice.service.exchange.job import Job, JobInfo
from motionsplice.service.exchange.uploads import Quota, Uploads
from motionsplice.service.problems import UploadError
from motionsplice.service.routes import OCTETS, Responses, only_known_parameters, problem_response
from motionsplice.service.shared import Shared

QUIET = 15  # seconds without a change after which a comment keeps the connection alive
CLOSED = problem_response(403, "This service does not accept clips")
EVENTS: Responses = {
    200: {
        "description": "An event at each change",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}
BODY = {"requestBody": {"required": True, "content": {"application/octet-stream": {"schema": OCTETS}}}}


def exchange_routes(shared: Shared, job: Job | None) -> APIRouter:
    """Returns the routes below /v1. Without a job they answer 403, and what setting is missing."""
    router = APIRouter(prefix="/v1", tags=["clips"], dependencies=[Depends(only_known_parameters)])

    folder = shared.settings.clips
    quota = Quota(shared.settings.max_clips, shared.settings.max_stored)
    uploads = None if folder is None else Uploads(folder, shared.serving.bank.path, quota)

    def require_job() -> Job:
        settings = shared.settings
        for name, value in (("token", settings.token), ("clips", settings.clips)):
            if value is None:
                raise UploadError("this service does not accept clips", mend=f"Start it with --{name}")
        assert job is not None
        return job

    @router.post(
        "/clips",
        summary="Upload a clip",
        status_code=202,
        openapi_extra=BODY,
        responses={
            **CLOSED,
            **problem_response(408, "The file stopped coming"),
            **problem_response(413, "The file is too large, or the folder of clips is full"),
            **problem_response(422, "Not a motion file that fits the bank, or an invalid name or parameter"),
        },
    )
    async def post_clip(
        request: Request,
        name: Annotated[str, Query(description="File name", examples=["jump.bvh"])],
        kind: Annotated[Literal["locomotion", "action"] | None, Query(description="Kind of the clip")] = None,
        neutral: Annotated[str | None, Query(description="The clip to which its posture is relative")] = None,
        tags: Annotated[str | None, Query(description="Tags, comma-separated")] = None,
    ) -> JobInfo:
        """Stores the motion file in the body, replaces a clip of the same name, and starts the offline job."""
        job, settings = require_job(), shared.settings
        assert uploads is not None
        listed = None if tags is None else tuple(tag.strip() for tag in tags.split(",") if tag.strip())
        body = steady_chunks(
            request.scope, request.receive, settings.max_upload, settings.request_seconds, shared.arrivals
        )
        await uploads.take(name, EntryUpdate(kind, neutral, listed), body)
        job.ask()
        return await job.look()

    @router.get("/job", summary="The offline job", responses=CLOSED)
    async def get_job() -> JobInfo:
        """Its progress, the clips that are not in the bank yet, and the reasons for failures."""
        return await require_job().look()

    @router.get("/job/events", summary="The offline job as server-sent events", response_class=StreamingResponse,
                responses={**EVENTS, **CLOSED})  # fmt: skip
    async def get_job_events() -> StreamingResponse:
        """The same as server-sent events: one now, and one at each change."""
        events = _events(require_job(), shared)
        return StreamingResponse(events, media_type="text/event-stream", headers={"cache-control": "no-store"})

    return router


async def _events(job: Job, shared: Shared) -> AsyncIterator[bytes]:
    quiet = 0
    await job.look()
    async for info in job.changes(shared.stopping.is_set):
        if info is not None:
            quiet = 0
            yield b"data: " + orjson.dumps(info.model_dump()) + b"\n\n"
        elif (quiet := quiet + 1) % QUIET == 0:
            yield b":\n\n"
