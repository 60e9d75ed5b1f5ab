"""The HTTP interface to a bank. Every handler runs on the event loop, which alone uses the evaluator."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, HTTPException, Path, Query, Response
from fastapi.responses import StreamingResponse

from runtime.evaluator import Evaluator
from service.models import BankInfo, ClipInfo, Pose, PoseRequest, StreamRequest
from service.settings import Settings
from service.stream import MEDIA_TYPES, Clock, frame_times, messages

Responses = dict[int | str, dict[str, Any]]


def _problem(status: int, description: str) -> Responses:
    schema = {"$ref": "#/components/schemas/Problem"}
    return {status: {"description": description, "content": {"application/problem+json": {"schema": schema}}}}


UNKNOWN = _problem(404, "Unknown clip; the near names are suggested")
REFUSED = _problem(422, "A time, method or number that means nothing")
NOT_READY = _problem(503, "Kernels are still being compiled")


class Readiness:
    """Whether the kernels are warm."""

    ready = False

    def check(self) -> None:
        """Raises HTTPException 503 until they are."""
        if not self.ready:
            raise HTTPException(503, "kernels are still being compiled; ask /readyz")


def bank_routes(evaluator: Evaluator, settings: Settings, readiness: Readiness) -> APIRouter:
    """Routes below /v1: what is in the bank, poses and streams."""
    router, bank = APIRouter(prefix="/v1"), evaluator.bank

    @router.get("/bank", tags=["bank"], summary="The bank and its skeleton")
    async def get_bank() -> BankInfo:
        return BankInfo.of(bank)

    @router.get("/clips", tags=["bank"], summary="All clips")
    async def get_clips() -> list[ClipInfo]:
        return [ClipInfo.of(bank, clip) for clip in bank.clips]

    @router.get("/clips/{name}", tags=["bank"], summary="One clip", responses={**UNKNOWN, **REFUSED})
    async def get_clip(name: Annotated[str, Path(examples=["walk"])]) -> ClipInfo:
        return ClipInfo.of(bank, bank.clip(name))

    @router.get("/pose", tags=["motion"], summary="One pose of a splice", responses={**UNKNOWN, **REFUSED, **NOT_READY})
    async def get_pose(request: Annotated[PoseRequest, Query()]) -> Pose:
        readiness.check()
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
        description="Length-delimited MessagePack, or JSON lines; docs/protocol.md describes the bytes.",
        response_class=StreamingResponse,
        responses={200: {"content": {kind: {} for kind in MEDIA_TYPES.values()}}, **UNKNOWN, **REFUSED, **NOT_READY},
    )
    async def get_splice(request: Annotated[StreamRequest, Query()]) -> StreamingResponse:
        readiness.check()
        times = frame_times(evaluator, request, settings.max_frames)
        clock = Clock(asyncio.get_running_loop().time, asyncio.sleep)
        return StreamingResponse(messages(evaluator, request, times, clock), media_type=MEDIA_TYPES[request.format])

    return router


def health_routes(readiness: Readiness) -> APIRouter:
    """Liveness and readiness, for whatever watches the process."""
    router = APIRouter(tags=["health"])

    @router.get("/healthz", summary="Is the process alive?", status_code=204, response_class=Response)
    async def get_health() -> Response:
        return Response(status_code=204)

    @router.get(
        "/readyz", summary="Are the kernels warm?", status_code=204, response_class=Response, responses={**NOT_READY}
    )
    async def get_readiness() -> Response:
        readiness.check()
        return Response(status_code=204)

    return router
