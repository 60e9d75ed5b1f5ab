"""Clips that were read, strides and prepared clips as entries of the cache, and back to the last bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.files import Reading
from motionsplice.motion.roles import Roles
from motionsplice.motion.skeleton import Skeleton
from motionsplice.precompute.alignment.baseline import Alignment, Baseline
from motionsplice.precompute.body.rig import Rig
from motionsplice.precompute.job.cache import Arrays, Said
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
    """A clip's rig, and the stride that was found in it, if any was."""

    rig: Rig
    ring: Baseline | None

    def found(self) -> FoundStride | None:
        return FoundStride(self.rig, self.ring) if self.ring is not None else None


def pack_stride(stride: StrideSearched) -> tuple[Said, Arrays]:
    ring = stride.ring
    said = {"rig": pack_rig(stride.rig), "ring": None}
    if ring is None:
        return said, {}
    return said | {"ring": [ring.start, ring.end, ring.loop, ring.leg, ring.zero]}, {"clouds": ring.clouds}


def unpack_stride(name: str, said: Said, arrays: Arrays) -> StrideSearched:
    """The stride of the clip of this name. Raises KeyError, TypeError, ValueError or MotionError if it is none."""
    rig = _rig(said["rig"])
    if said["ring"] is None:
        return StrideSearched(rig, None)
    start, end, loop, leg, zero = said["ring"]
    return StrideSearched(rig, Baseline(name, start, end, loop, leg, zero, arrays["clouds"]))


def pack_reading(reading: Reading) -> tuple[Said, Arrays]:
    """All but the name."""
    clip = reading.clip
    said = {
        "rig": pack_rig(Rig(clip.skeleton, reading.roles)),
        "rate": float(clip.rate),
        "unit": reading.unit,
        "notes": reading.notes,
        "warnings": reading.warnings,
    }
    return said, {"positions": clip.root_positions, "rotations": clip.rotations}


def unpack_reading(name: str, said: Said, arrays: Arrays) -> Reading:
    """The clip of this name as it was read. Raises KeyError, TypeError, ValueError or MotionError if it is none."""
    rig = _rig(said["rig"])
    clip = Clip(name, rig.skeleton, said["rate"], arrays["positions"], arrays["rotations"])
    return Reading(clip, rig.roles, said["unit"], tuple(said["notes"]), tuple(said["warnings"]))


def pack_rig(rig: Rig) -> Said:
    skeleton = rig.skeleton
    return {
        "names": skeleton.names,
        "parents": skeleton.parents.tolist(),
        "offsets": skeleton.offsets.tolist(),
        "end_parents": skeleton.end_parents.tolist(),
        "end_offsets": skeleton.end_offsets.tolist(),
        "roles": asdict(rig.roles),
    }


def _rig(said: Any) -> Rig:
    skeleton = Skeleton(
        names=tuple(said["names"]),
        parents=np.array(said["parents"], np.int64),
        offsets=np.array(said["offsets"], np.float64),
        end_parents=np.array(said["end_parents"], np.int64),
        end_offsets=np.array(said["end_offsets"], np.float64).reshape(-1, 3),
    )
    return Rig(skeleton, Roles(**said["roles"] | {"spine": tuple(said["roles"]["spine"])}))


def pack_prepared(one: PreparedClip) -> tuple[Said, Arrays]:
    """All but the name and the settings, on which nothing of it depends."""
    alignment = one.alignment
    said = {
        "rate": one.rate,
        "frame_count": one.frame_count,
        "strides": one.strides,
        "chance": alignment.chance,
        "swing": alignment.swing,
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
        "gait": one.gait,
        "stride": one.stride.coefficients,
    }
    return said, small | {name: one.fetch(name) for name in LARGE}


def unpack_prepared(name: str, fetch: Callable[[str], NDArray[Any]], said: Said, arrays: Arrays) -> PreparedClip:
    """The clip by this name, of which `fetch` gets what is large. Raises KeyError, TypeError or ValueError."""
    phase, aligned = arrays["phase"], arrays["aligned"]
    if not 2 <= len(aligned) == said["frame_count"] <= len(phase):
        raise ValueError("a clip has more frames than rows")
    return PreparedClip(
        name=name,
        rate=said["rate"],
        frame_count=said["frame_count"],
        strides=said["strides"],
        alignment=Alignment(aligned, arrays["cost"], said["chance"], said["swing"]),
        phase=phase,
        posture=arrays["posture"],
        path=arrays["path"],
        contacts=arrays["contacts"],
        gait=arrays["gait"],
        stride=MeanStride(arrays["stride"]),
        fetch=fetch,
        notes=tuple(said["notes"]),
        file_warnings=tuple(said["warnings"]),
    )
