"""Routes about the service and its bank. Games do not request them every tick, so FastAPI answers them."""

from __future__ import annotations

import asyncio
import os
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Query, Request, Response
from fastapi.responses import FileResponse
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import Message, Receive, Scope, Send

from motionsplice.motion.axes import AXES, AxesName
from motionsplice.motion.errors import did_you_mean
from motionsplice.service.models import BankInfo, ClipInfo, ServerInfo, SkeletonInfo
from motionsplice.service.problems import MEDIA_TYPE, RequestError, UnknownBankError, stopping
from motionsplice.service.report import QualityReport, ReportFile
from motionsplice.service.shared import Shared

Responses = dict[int | str, dict[str, Any]]
OCTETS = {"type": "string", "format": "binary"}
TEXT = {"type": "string"}


def problem_response(status: int | str, description: str) -> Responses:
    """Returns the entry of a problem in the schema."""
    schema = {"$ref": "#/components/schemas/Problem"}
    return {status: {"description": description, "content": {MEDIA_TYPE: {"schema": schema}}}}


UNKNOWN = problem_response(404, "Unknown clip, table or bank; similar names are suggested")
REFUSED = problem_response(422, "A parameter that is unknown, missing or invalid")
NOT_READY = problem_response(503, "The kernels are still being compiled")


def only_known_parameters(request: Request) -> None:
    """Raises RequestError for an unknown parameter, which FastAPI would ignore."""
    known = [field.alias for field in request.scope["route"].dependant.query_params]
    for name in request.query_params:
        if name not in known:
            mend = did_you_mean(name[:40], known) if known else "This request has no parameters"
            raise RequestError(f"unknown parameter {name[:40]!r}", mend=mend)


class TableResponse(FileResponse):
    """A file. A range that cannot be answered is a problem, not text as in FileResponse."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def send_or_raise(message: Message) -> None:
            if message["type"] == "http.response.start" and (status := message["status"]) >= 400:
                detail = "the range is outside the file" if status == 416 else "the header Range is malformed"
                size = Headers(raw=message["headers"]).get("content-range")  # old versions of Starlette omit "bytes"
                raise HTTPException(
                    status, detail, {"content-range": f"bytes {size.removeprefix('bytes ')}"} if size else None
                )
            await send(message)

        await super().__call__(scope, receive, send_or_raise)


def bank_routes(shared: Shared) -> APIRouter:
    """Returns the routes below /v1 about the service and its bank."""
    router = APIRouter(prefix="/v1", tags=["bank"], dependencies=[Depends(only_known_parameters)])
    serving = shared.serving

    @router.get("/server", summary="The service")
    async def get_server() -> ServerInfo:
        """The digest of its bank, its axes and encodings, and its limits."""
        return ServerInfo.of(serving.bank, shared.settings, ready=serving.ready)

    @router.get("/bank", summary="The bank")
    async def get_bank() -> BankInfo:
        """Its digest, under which answers can be cached, and its tables."""
        return BankInfo.of(serving.bank)

    @router.get("/skeleton", summary="The skeleton", responses=REFUSED)
    async def get_skeleton(
        axes: Annotated[AxesName, Query(description="Axes of the offsets")] = "gltf",
    ) -> SkeletonInfo:
        """Joints in the order of all rotations, their parents and offsets, and the joint of each role."""
        return SkeletonInfo.of(serving.bank, AXES[axes])

    @router.get("/clips", summary="All clips")
    async def get_clips() -> list[ClipInfo]:
        """All clips that can be spliced, and how well each is aligned to the baseline."""
        return [ClipInfo.of(serving.bank, clip) for clip in serving.bank.clips]

    @router.get("/clips/{name}", summary="One clip", responses={**UNKNOWN, **REFUSED})
    async def get_clip(name: Annotated[str, Path(description="A clip name, as in the list of all clips")]) -> ClipInfo:
        """One entry of the list of all clips."""
        return ClipInfo.of(serving.bank, serving.bank.clip(name))

    report = ReportFile(shared.settings.report)

    @router.get(
        "/report",
        summary="How good its splices are",
        response_class=Response,
        responses={
            200: {"description": "The report", "model": QualityReport},
            **problem_response(404, "This service has no report"),
        },
    )
    async def get_report() -> Response:
        """What `bench.quality` measured, pair by pair. Compare its `bank` with the one that is served."""
        return Response(await asyncio.to_thread(report.read), media_type="application/json")

    @router.get(
        "/manifest",
        summary="The bank's manifest",
        response_class=Response,
        responses={200: {"description": "The file", "content": {"application/msgpack": {"schema": OCTETS}}}},
    )
    async def get_manifest() -> Response:
        """The file `manifest.msgpack`, which docs/bank.md describes."""
        return Response(serving.bank.manifest.data, media_type="application/msgpack")

    @router.get(
        "/tables/{name}",
        summary="A table of the bank",
        response_class=FileResponse,
        responses={
            200: {"description": "The .npy file", "content": {"application/octet-stream": {"schema": OCTETS}}},
            206: {"description": "A range of it", "content": {"application/octet-stream": {"schema": OCTETS}}},
            **problem_response(416, "A range outside the file"),
            **UNKNOWN,
            **REFUSED,
        },
    )
    async def get_table(name: Annotated[str, Path(description="A table name, as in `/v1/bank`")]) -> FileResponse:
        """A `.npy` file. `Range` is supported."""
        files = serving.bank.files
        if name not in files:
            raise UnknownBankError(f"the bank has no table {name!r:.40}", mend=did_you_mean(name[:40], files))
        try:
            found = os.stat(files[name])
        except FileNotFoundError:
            raise UnknownBankError("the table is no longer on disk", mend="Request it from the newest bank") from None
        return TableResponse(files[name], media_type="application/octet-stream", stat_result=found)

    return router


def health_routes(shared: Shared) -> APIRouter:
    """Returns the routes for monitoring: liveness, readiness and metrics."""
    router = APIRouter(tags=["service"])

    @router.get("/healthz", summary="Is the process alive?", status_code=204, response_class=Response)
    async def get_health() -> Response:
        """Answers 204 as soon as the service listens."""
        return Response(status_code=204)

    @router.get(
        "/readyz", summary="Are the kernels compiled?", status_code=204, response_class=Response, responses=NOT_READY
    )
    async def get_readiness() -> Response:
        """Answers 204 once the kernels are compiled, and 503 before and while the service stops."""
        if shared.stopping.is_set():
            raise stopping()
        _ = shared.serving.edition
        return Response(status_code=204)

    @router.get(
        "/metrics",
        summary="Metrics for Prometheus",
        response_class=Response,
        responses={200: {"description": "In Prometheus' text format", "content": {"text/plain": {"schema": TEXT}}}},
    )
    async def get_metrics() -> Response:
        """Frames sent and skipped, lateness of ticks, evaluation time, connections, requests (docs/operation.md)."""
        body, media_type = shared.metrics.render()
        return Response(body, headers={"content-type": media_type})

    return router
