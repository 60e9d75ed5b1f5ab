"""Packs readings, strides and prepared clips as cache entries, and unpacks them, exact to the last bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.reading import Reading
from motionsplice.motion.retarget.rig import Rig
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.alignment.alignment import Alignment
from motionsplice.precompute.alignment.baseline import Baseline
from motionsplice.precompute.alignment.stretches import Stretch
from motionsplice.precompute.job.cache import Arrays, Fields
from motionsplice.precompute.preparation.prepared import PreparedClip
from motionsplice.precompute.preparation.torso_offset import MeanStride

LARGE = ("lower", "upper", "upright")


@dataclass(frozen=True, eq=False)
class FoundStride:
    """A stride that a bank can be aligned to, and the rig of its clip."""

    rig: Rig
    ring: Baseline


@dataclass(frozen=True, eq=False)
class StrideSearched:
    """The result of searching a clip for a stride: its rig, and the stride or None."""

    rig: Rig
    ring: Baseline | None

    def found(self) -> FoundStride | None:
        """Returns the stride with its rig; None if the clip has no stride."""
        return FoundStride(self.rig, self.ring) if self.ring is not None else None


def pack_stride(stride: StrideSearched) -> tuple[Fields, Arrays]:
    """Packs everything except the clip's name."""
    ring = stride.ring
    fields: Fields = {"rig": pack_rig(stride.rig), "ring": None}
    if ring is None:
        return fields, {}
    fields["ring"] = [ring.start, ring.end, ring.loop, ring.leg, ring.zero]
    return fields, {"clouds": ring.clouds, "support": ring.support}


def unpack_stride(name: str, fields: Fields, arrays: Arrays) -> StrideSearched:
    """Unpacks the stride of the named clip. Raises KeyError, TypeError, ValueError or MotionError for a bad entry."""
    rig = _rig(fields["rig"])
    if fields["ring"] is None:
        return StrideSearched(rig, None)
    start, end, loop, leg, zero = fields["ring"]
    return StrideSearched(rig, Baseline(name, start, end, loop, leg, zero, arrays["clouds"], arrays["support"]))


def pack_reading(reading: Reading) -> tuple[Fields, Arrays]:
    """Packs everything except the clip's name."""
    clip = reading.clip
    fields = {
        "rig": pack_rig(Rig(clip.skeleton, reading.roles)),
        "rate": float(clip.rate),
        "unit": reading.unit,
        "notes": reading.notes,
        "warnings": reading.warnings,
    }
    return fields, {"positions": clip.root_positions, "rotations": clip.rotations}


def unpack_reading(name: str, fields: Fields, arrays: Arrays) -> Reading:
    """Unpacks the reading of the named clip. Raises KeyError, TypeError, ValueError or MotionError for a bad entry."""
    rig = _rig(fields["rig"])
    clip = Clip(name, rig.skeleton, fields["rate"], arrays["positions"], arrays["rotations"])
    return Reading(clip, rig.roles, fields["unit"], tuple(fields["notes"]), tuple(fields["warnings"]))


def pack_rig(rig: Rig) -> Fields:
    """Packs a skeleton, its roles and its standing pose."""
    skeleton = rig.skeleton
    return {
        "names": skeleton.names,
        "parents": skeleton.parents.tolist(),
        "offsets": skeleton.offsets.tolist(),
        "end_parents": skeleton.end_parents.tolist(),
        "end_offsets": skeleton.end_offsets.tolist(),
        "roles": vars(rig.roles),
        "pose": None if rig.pose is None else rig.pose.tolist(),
    }


def _rig(fields: Any) -> Rig:
    skeleton = Skeleton(
        names=tuple(fields["names"]),
        parents=np.array(fields["parents"], np.int64),
        offsets=np.array(fields["offsets"], np.float64),
        end_parents=np.array(fields["end_parents"], np.int64),
        end_offsets=np.array(fields["end_offsets"], np.float64).reshape(-1, 3),
    )
    roles = Roles(**fields["roles"] | {"spine": tuple(fields["roles"]["spine"])})
    return Rig(skeleton, roles, None if fields["pose"] is None else np.array(fields["pose"], np.float64))


def pack_prepared(one: PreparedClip) -> tuple[Fields, Arrays]:
    """Packs everything except the name and the settings, which do not affect the rest."""
    alignment = one.alignment
    fields = {
        "rate": one.rate,
        "frame_count": one.frame_count,
        "strides": one.strides,
        "period": one.period,
        "foreign": alignment.foreign,
        "swing": alignment.swing,
        "repetition": one.repetition,
        "stretches": [astuple(one) for one in alignment.stretches],
        "notes": one.notes,
        "warnings": one.file_warnings,
    }
    small: dict[str, NDArray[Any]] = {
        "aligned": alignment.phase,
        "cost": alignment.cost,
        "phase": one.phase,
        "posture": one.posture,
        "path": one.path,
        "contacts": one.contacts,
        "feet": one.feet,
        "gait": one.gait,
        "stride": one.stride.coefficients,
    }
    return fields, small | {name: one.fetch(name) for name in LARGE}


def unpack_prepared(name: str, fetch: Callable[[str], NDArray[Any]], fields: Fields, arrays: Arrays) -> PreparedClip:
    """Unpacks the named clip, whose large arrays `fetch` returns. Raises KeyError, TypeError or ValueError."""
    phase, aligned = arrays["phase"], arrays["aligned"]
    if not 2 <= len(aligned) == fields["frame_count"] <= len(phase):
        raise ValueError("the frame count does not match the arrays")
    return PreparedClip(
        name=name,
        rate=fields["rate"],
        frame_count=fields["frame_count"],
        strides=fields["strides"],
        period=fields["period"],
        alignment=Alignment(
            aligned,
            arrays["cost"],
            fields["foreign"],
            fields["swing"],
            tuple(Stretch(*one) for one in fields["stretches"]),
        ),
        phase=phase,
        posture=arrays["posture"],
        path=arrays["path"],
        contacts=arrays["contacts"],
        feet=arrays["feet"],
        gait=arrays["gait"],
        stride=MeanStride(arrays["stride"]),
        repetition=fields["repetition"],
        fetch=fetch,
        notes=tuple(fields["notes"]),
        file_warnings=tuple(fields["warnings"]),
    )
