"""The HTTP interface to a bank. Every handler runs on the event loop, which alone uses the evaluator."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Path, Query, Response
from fastapi.responses import StreamingResponse

from runtime.bank import Bank
from service.models import BankInfo, ClipInfo, Pose, PoseRequest, StreamRequest
from service.readiness import Readiness
from service.settings import Settings
from service.stream import MEDIA_TYPES, Clock, frame_times, messages

Responses = dict[int | str, dict[str, Any]]


def _problem(status: int, description: str) -> Responses:
    schema = {"$ref": "#/components/schemas/Problem"}
    return {status: {"description": description, "content": {"application/problem+json": {"schema": schema}}}}


UNKNOWN = _problem(404, "Unknown clip; the near names are suggested")
REFUSED = _problem(422, "A time, method or number that means nothing")
NOT_READY = _problem(503, "Kernels are still being compiled")


def bank_routes(bank: Bank, settings: Settings, readiness: Readiness) -> APIRouter:
    """Routes below /v1: what is in the bank, poses and streams."""
    router = APIRouter(prefix="/v1")

    @router.get("/bank", tags=["bank"], summary="The bank and its skeleton")
    async def get_bank() -> BankInfo:
        """Its digest, and the joints in the order in which all rotations come."""
        return BankInfo.of(bank)

    @router.get("/clips", tags=["bank"], summary="All clips")
    async def get_clips() -> list[ClipInfo]:
        """What can be spliced, and how well each clip is aligned to the baseline."""
        return [ClipInfo.of(bank, clip) for clip in bank.clips]

    @router.get("/clips/{name}", tags=["bank"], summary="One clip", responses={**UNKNOWN, **REFUSED})
    async def get_clip(name: Annotated[str, Path(description="A clip's name, as in the list of all")]) -> ClipInfo:
        """One entry of the list of all clips."""
        return ClipInfo.of(bank, bank.clip(name))

    @router.get("/pose", tags=["motion"], summary="One pose of a splice", responses={**UNKNOWN, **REFUSED, **NOT_READY})
    async def get_pose(request: Annotated[PoseRequest, Query()]) -> Pose:
        """The splice at one moment, computed alone: it costs the same at the end of a clip as at its start."""
        evaluator = readiness.evaluator()
        poses = evaluator.pose(
            request.locomotion,
            request.time,
            request.action,
            start=request.start,
            method=request.method,
            posture=request.posture,
        )
        world = None
        if request.world:
            positions = np.empty((1, bank.skeleton.joint_count, 3), np.float32)
            evaluator.world_positions(poses, positions)
            world = positions[0].tolist()
        return Pose(
            locomotion=request.locomotion,
            action=request.action,
            time=request.time,
            root_position=poses.root_positions[0].tolist(),
            rotations=poses.rotations[0].tolist(),
            world_positions=world,
        )

    @router.get(
        "/splice",
        tags=["motion"],
        summary="A whole splice as a stream of frames",
        response_class=StreamingResponse,
        responses={200: {"content": {kind: {} for kind in MEDIA_TYPES.values()}}, **UNKNOWN, **REFUSED, **NOT_READY},
    )
    async def get_splice(request: Annotated[StreamRequest, Query()]) -> StreamingResponse:
        """A header, then one message a frame.

        For engines each message is its length, four bytes big-endian, and that many bytes of a MessagePack map; with
        `format=json` it is a line of JSON. docs/protocol.md describes the bytes.
        """
        evaluator = readiness.evaluator()
        times = frame_times(evaluator, request, settings.max_frames)
        clock = Clock(asyncio.get_running_loop().time, asyncio.sleep)
        return StreamingResponse(messages(evaluator, request, times, clock), media_type=MEDIA_TYPES[request.format])

    return router


def health_routes(readiness: Readiness) -> APIRouter:
    """Liveness and readiness, for whatever watches the process."""
    router = APIRouter(tags=["health"])

    @router.get("/healthz", summary="Is the process alive?", status_code=204, response_class=Response)
    async def get_health() -> Response:
        """Answers as soon as the service listens."""
        return Response(status_code=204)

    @router.get(
        "/readyz", summary="Are the kernels warm?", status_code=204, response_class=Response, responses={**NOT_READY}
    )
    async def get_readiness() -> Response:
        """Poses and streams are served from then on."""
        readiness.evaluator()
        return Response(status_code=204)

    return router
