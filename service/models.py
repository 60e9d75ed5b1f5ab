"""Models of the answers about the service, its bank and its clips."""

from __future__ import annotations

from collections.abc import Iterable

from pydantic import BaseModel, Field

from motionsplice import __version__
from motionsplice.motion.axes import AXES, Axes
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.contacts import FEET, Contact
from motionsplice.runtime.format.entries import ClipEntry
from motionsplice.service.report import ReportFile
from motionsplice.service.settings import Settings
from motionsplice.service.wire.encoding import INT16_ERROR, NUMBERS, PARTS
from motionsplice.service.wire.messages import PROTOCOL
from motionsplice.service.wire.rig import rig_fields

LIMITS = tuple(name for name in Settings.model_fields if name.startswith("max_") or name.endswith("_seconds"))


class AxesInfo(BaseModel):
    """Axes and unit of an engine: component i is glTF's component `order[i]` times `signs[i]`, in `unit`."""

    name: str
    description: str
    unit: str
    metres: float = Field(description="length of one unit in metres")
    order: tuple[int, int, int]
    signs: tuple[int, int, int]

    @classmethod
    def of(cls, axes: Axes) -> AxesInfo:
        return cls(
            name=axes.name,
            description=axes.description,
            unit=axes.unit,
            metres=1.0 / axes.scale,
            order=axes.order,
            signs=axes.signs,
        )


class ServerInfo(BaseModel):
    """The service: its bank, its encodings and its limits."""

    version: str
    protocol: int = Field(description="version of docs/protocol.md")
    bank: str = Field(description="digest of the bank")
    ready: bool
    axes: list[AxesInfo]
    encodings: list[str]
    int16_error: float = Field(description="largest error of a rotation in int16, degrees")
    parts: list[str]
    uploads: bool = Field(description="whether clips can be uploaded")
    report: bool = Field(description="whether there is a report of quality")
    limits: dict[str, int | float]

    @classmethod
    def of(cls, bank: Bank, settings: Settings, *, ready: bool) -> ServerInfo:
        return cls(
            version=__version__,
            protocol=PROTOCOL,
            bank=bank.digest,
            ready=ready,
            axes=[AxesInfo.of(axes) for axes in AXES.values()],
            encodings=list(NUMBERS),
            int16_error=INT16_ERROR,
            parts=list(PARTS),
            uploads=settings.clips is not None and settings.token is not None,
            report=ReportFile(settings.report).exists,
            limits={name: getattr(settings, name) for name in LIMITS},
        )


class TableInfo(BaseModel):
    """One table of the bank, a .npy file."""

    name: str
    digest: str
    shape: list[int]
    type: str
    bytes: int


class BankInfo(BaseModel):
    """The bank that is served."""

    digest: str
    baseline: str
    clips: int
    joints: int
    seconds: float = Field(description="total duration of all clips")
    tables: list[TableInfo]

    @classmethod
    def of(cls, bank: Bank) -> BankInfo:
        tables = bank.manifest.tables
        return cls(
            digest=bank.digest,
            baseline=bank.baseline.clip,
            clips=len(bank.clips),
            joints=bank.skeleton.joint_count,
            seconds=sum(clip.duration for clip in bank.clips),
            tables=[
                TableInfo(
                    name=name,
                    digest=tables[name],
                    shape=list(table.shape),
                    type=table.dtype.name,
                    bytes=table.nbytes,
                )
                for name, table in bank.tables.items()
            ],
        )


class SkeletonInfo(BaseModel):
    """The skeleton: joints in the order of all rotations, and offsets in the requested axes."""

    axes: AxesInfo
    joints: list[str]
    parents: list[int] = Field(description="index of each joint's parent; -1 for the root")
    offsets: list[list[float]] = Field(description="from the parent")
    roles: dict[str, str | list[str] | None] = Field(description="name of the joint or joints of each role")

    @classmethod
    def of(cls, bank: Bank, axes: Axes) -> SkeletonInfo:
        return cls(axes=AxesInfo.of(axes), **rig_fields(bank, axes))


class ContactsInfo(BaseModel):
    """Stances of each foot in order: seconds at which it touches down and lifts off, or the clip's first or last."""

    left: list[tuple[float, float]]
    right: list[tuple[float, float]]

    @classmethod
    def of(cls, contacts: Iterable[Contact]) -> ContactsInfo:
        feet: dict[str, list[tuple[float, float]]] = {foot: [] for foot in FEET}
        for one in contacts:
            feet[one.foot].append((round(one.down, 4), round(one.up, 4)))
        return cls(**feet)


class ClipInfo(BaseModel):
    """One clip. Durations are in seconds, mismatches in metres, the rate in frames per second."""

    name: str
    kind: str
    tags: list[str]
    duration: float
    rate: float
    frames: int
    cycles: float = Field(description="number of strides")
    loop: int = Field(description="number of strides that can be repeated seamlessly; 0: none")
    neutral: str = Field(description="the clip to which its posture is relative")
    hands: list[str] = Field(description="hands clips that can be laid on it")
    contacts: ContactsInfo = Field(description="contacts of its feet with the ground")
    mean_mismatch: float = Field(description="mean distance of root and knees from the baseline's")
    worst_mismatch: float = Field(description="largest distance of root and knees from the baseline's")
    shoulder_motion: float = Field(description="motion of the torso beyond the neutral's gait, radians")
    repetition: float = Field(description="mean distance of the upper body from itself a stride later; 0: unknown")
    stands: bool = Field(description="whether it is an action without a gait, which plays at its own speed")
    uses: list[str] = Field(description="parts of the upper body that such an action uses")
    stretches: list[str] = Field(description="clips that an action which stands and walks by turns plays in order")
    warnings: list[str]
    notes: list[str]
    source: str = Field(description="digest of its motion file")

    @classmethod
    def of(cls, bank: Bank, clip: ClipEntry) -> ClipInfo:
        return cls(
            name=clip.name,
            kind=clip.kind,
            tags=list(clip.tags),
            duration=clip.duration,
            rate=clip.rate,
            frames=clip.frame_count,
            cycles=clip.cycles,
            loop=clip.loop,
            neutral=bank.neutral(clip.name),
            hands=[one.name for one in bank.hands if one.body == clip.name],
            contacts=ContactsInfo.of(bank.contacts(clip.name)),
            mean_mismatch=clip.mean_mismatch,
            worst_mismatch=clip.worst_mismatch,
            shoulder_motion=clip.shoulder_motion,
            repetition=clip.repetition,
            stands=clip.stands,
            uses=list(clip.uses),
            stretches=list(clip.stretches),
            warnings=list(clip.warnings),
            notes=list(clip.notes),
            source=clip.source,
        )
