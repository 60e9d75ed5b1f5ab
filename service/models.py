"""What the service takes and answers."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from runtime.bank import Bank
from runtime.manifest import ClipEntry
from runtime.requests import Method, Posture

AXES = "right-handed, Y up, Z forward"
UNITS = "metres, seconds; unit quaternions xyzw"

Finite = Annotated[float, Field(allow_inf_nan=False)]


class Splice(BaseModel):
    """Which upper body on which lower body, and how."""

    model_config = ConfigDict(extra="forbid")  # a misspelt `action` would else be answered with no action

    locomotion: str = Field(description="Clip that gives the root and the lower body")
    action: str | None = Field(
        default=None, description="Clip that gives the upper body; without it, the locomotion alone"
    )
    start: Finite = Field(default=0.0, ge=0.0, description="Seconds into the action before which it does not begin")
    method: Method = Field(default="splice", description="`naive` is plain replacement of the upper body's joints")
    posture: Posture = Field(default="relative", description="What becomes of the action's posture")


class PoseRequest(Splice):
    """One moment of a splice."""

    time: Finite = Field(ge=0.0, description="Seconds into the locomotion")
    world: bool = Field(default=False, description="Also answer world positions of all joints")


class StreamRequest(Splice):
    """A whole splice."""

    rate: Finite | None = Field(default=None, gt=0.0, le=1000.0, description="Frames per second; else the clip's own")
    pace: Literal["fast", "realtime"] = Field(default="fast", description="As fast as possible, or at the clip's pace")
    format: Literal["msgpack", "json"] = Field(
        default="msgpack", description="Binary for engines, lines of JSON for people"
    )


class Pose(BaseModel):
    """Root position in metres; local rotations xyzw by joint; world positions in metres if asked for."""

    locomotion: str
    action: str | None
    time: float
    root_position: list[float]
    rotations: list[list[float]]
    world_positions: list[list[float]] | None = None


class BankInfo(BaseModel):
    """The bank that is served, and its skeleton: parents by index, the root's is -1; offsets in metres."""

    digest: str
    axes: str = AXES
    units: str = UNITS
    baseline: str
    clips: int
    joints: list[str]
    parents: list[int]
    offsets: list[list[float]]

    @classmethod
    def of(cls, bank: Bank) -> BankInfo:
        """What is to be said of a bank."""
        return cls(
            digest=bank.digest,
            baseline=bank.baseline.clip,
            clips=len(bank.clips),
            joints=list(bank.skeleton.names),
            parents=bank.skeleton.parents.tolist(),
            offsets=bank.skeleton.offsets.tolist(),
        )


class ClipInfo(BaseModel):
    """One clip: seconds, frames per second, strides, and how far its legs are from the baseline's, metres."""

    name: str
    kind: str
    tags: list[str]
    duration: float
    rate: float
    frames: int
    cycles: float
    neutral: str
    mean_mismatch: float
    worst_mismatch: float
    warnings: list[str]

    @classmethod
    def of(cls, bank: Bank, clip: ClipEntry) -> ClipInfo:
        """What is to be said of a bank's clip."""
        return cls(
            name=clip.name,
            kind=clip.kind,
            tags=list(clip.tags),
            duration=clip.duration,
            rate=clip.rate,
            frames=clip.frame_count,
            cycles=clip.cycles,
            neutral=bank.neutral(clip.name),
            mean_mismatch=clip.mean_mismatch,
            worst_mismatch=clip.worst_mismatch,
            warnings=list(clip.warnings),
        )
