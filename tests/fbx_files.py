"""ASCII FBX 7.4 files made from clips, for tests, with the units, axes and bind poses that exporters use."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.clip import Clip
from motionsplice.motion.quaternion import Floats

SECOND = 46186158000  # ticks
LINEAR = 4
AXES = {"y": (1, 1, 2, 1, 0, 1), "z": (2, 1, 1, -1, 0, 1)}  # up, front and right, each with its sign
TIME_MODES = {24.0: 11, 30.0: 6, 60.0: 3, 100.0: 2, 120.0: 1}
ROOT, SKIN, GEOMETRY, MESH, POSE = range(1, 6)


@dataclass(frozen=True, eq=False)
class Variant:
    """How a file is written.

    unit: metres per unit. up: "y" or "z". rate: the file's frame rate, if it is not the first clip's. kind: what the
    joints are, "LimbNode" or "Null". bone_axes: [J, 4] each joint's own axes in the bind pose, made by pre-rotations.
    scale: of the whole skeleton, by an armature above it. rest: the frame of the first clip in which nodes rest, None
    for the bind pose. bind: what states the bind pose, "pose", "skin" or nothing. objects, connections: further lines.
    """

    unit: float = 0.01
    up: str = "y"
    rate: float | None = None
    kind: str = "LimbNode"
    bone_axes: Floats | None = None
    scale: float = 1.0
    rest: int | None = None
    bind: str = ""
    objects: tuple[str, ...] = ()
    connections: tuple[str, ...] = ()


def dump_fbx(clips: Sequence[Clip], variant: Variant | None = None) -> bytes:
    """Returns an ASCII FBX file of one skeleton, with an animation stack for each clip."""
    file = _File(clips, variant or Variant())
    return file.text().encode()


class _File:
    def __init__(self, clips: Sequence[Clip], variant: Variant) -> None:
        self.clips, self.variant = clips, variant
        self.objects, self.connections = list(variant.objects), list(variant.connections)
        skeleton = clips[0].skeleton
        self.count = skeleton.joint_count
        self.own = quaternion.IDENTITY[None].repeat(self.count, 0) if variant.bone_axes is None else variant.bone_axes
        self.up = quaternion.about([1.0, 0.0, 0.0], np.pi / 2 if variant.up == "z" else 0.0)
        self.above = np.concatenate([quaternion.IDENTITY[None], self.own[skeleton.parents[1:]]])

    def text(self) -> str:
        self._armature()
        self._joints()
        if self.variant.bind:
            self._bind()
        for number, clip in enumerate(self.clips):
            self._stack(number, clip)
        return "\n".join([*self._head(), "Objects: {", *self.objects, "}", "Connections: {", *self.connections, "}"])

    def _head(self) -> list[str]:
        up, up_sign, front, front_sign, right, right_sign = AXES[self.variant.up]
        rate = self.variant.rate or self.clips[0].rate
        return [
            "; FBX 7.4.0 project file",
            "FBXHeaderExtension: {",
            "FBXHeaderVersion: 1003",
            "FBXVersion: 7400",
            "}",
            "GlobalSettings: {",
            "Version: 1000",
            "Properties70: {",
            f'P: "UpAxis", "int", "Integer", "",{up}',
            f'P: "UpAxisSign", "int", "Integer", "",{up_sign}',
            f'P: "FrontAxis", "int", "Integer", "",{front}',
            f'P: "FrontAxisSign", "int", "Integer", "",{front_sign}',
            f'P: "CoordAxis", "int", "Integer", "",{right}',
            f'P: "CoordAxisSign", "int", "Integer", "",{right_sign}',
            f'P: "UnitScaleFactor", "double", "Number", "",{100.0 * self.variant.unit}',
            f'P: "TimeMode", "enum", "", "",{TIME_MODES.get(rate, 14)}',
            f'P: "CustomFrameRate", "double", "Number", "",{rate}',
            "}",
            "}",
        ]

    def _armature(self) -> None:
        scale = (self.variant.scale,) * 3
        self._model(ROOT, "Armature", "Null", 0, {"Lcl Scaling": scale})

    def _model(self, number: int, name: str, kind: str, parent: int, vectors: Mapping[str, Iterable[float]]) -> None:
        lines = [f'P: "{key}", "{key}", "", "A",{_numbers(value)}' for key, value in vectors.items()]
        self.objects += [
            f'Model: {number}, "Model::{name}", "{kind}" {{',
            "Version: 232",
            "Properties70: {",
            'P: "RotationActive", "bool", "", "",1',
            *lines,
            "}",
            "}",
        ]
        self.connections.append(f'C: "OO",{number},{parent}')

    def _joints(self) -> None:
        skeleton = self.clips[0].skeleton
        translations, angles = self._local(self.clips[0]) if self.variant.rest is not None else self._bound()
        frame = self.variant.rest or 0
        pre = _degrees(self._pre())
        for joint, name in enumerate(skeleton.names):
            parent = joint_id(int(skeleton.parents[joint])) if joint else ROOT
            places = {
                "Lcl Translation": translations[frame, joint],
                "Lcl Rotation": angles[frame, joint],
                "PreRotation": pre[joint],
            }
            self._joint(joint_id(joint), name, parent, places)
        for end, parent in enumerate(skeleton.end_parents.tolist()):
            at = quaternion.rotate(quaternion.conjugate(self.own[parent]), skeleton.end_offsets[end])
            name, number = f"{skeleton.names[parent]}_end", joint_id(self.count + end)
            self._joint(number, name, joint_id(parent), {"Lcl Translation": self._length(at)})

    def _joint(self, number: int, name: str, parent: int, vectors: Mapping[str, Iterable[float]]) -> None:
        self._model(number, name, self.variant.kind, parent, vectors)
        self.objects.append(f'NodeAttribute: {number + 1}, "NodeAttribute::", "{self.variant.kind}" {{')
        self.objects += [f'TypeFlags: "{"Skeleton" if self.variant.kind == "LimbNode" else "Null"}"', "}"]
        self.connections.append(f'C: "OO",{number + 1},{number}')

    def _length(self, metres: Floats) -> Floats:
        return metres / (self.variant.unit * self.variant.scale)

    def _pre(self) -> Floats:
        pre = quaternion.multiply(quaternion.conjugate(self.above), self.own)
        pre[0] = quaternion.multiply(self.up, pre[0])
        return pre

    def _bound(self) -> tuple[Floats, Floats]:
        """The bind pose as a motion of one frame."""
        skeleton = self.clips[0].skeleton
        rotations = np.tile(quaternion.IDENTITY, (1, self.count, 1))
        return self._local(Clip("bind", skeleton, 1.0, skeleton.offsets[None, 0], rotations))

    def _local(self, clip: Clip) -> tuple[Floats, Floats]:
        """Translations [F, J, 3] in the file's unit and Euler angles [F, J, 3] in degrees, on the parents' own axes."""
        offsets = np.repeat(clip.skeleton.offsets[None], len(clip.rotations), 0)
        offsets[:, 0] = quaternion.rotate(self.up, clip.root_positions)
        turns = quaternion.multiply(quaternion.multiply(quaternion.conjugate(self.own), clip.rotations), self.own)
        return self._length(quaternion.rotate(quaternion.conjugate(self.above), offsets)), _degrees(turns)

    def _bind(self) -> None:
        skeleton = self.clips[0].skeleton
        places = skeleton.offsets.copy()
        for joint, parent in enumerate(skeleton.parents.tolist()[1:], 1):
            places[joint] += places[parent]
        matrices = np.tile(np.eye(4), (self.count, 1, 1))
        matrices[:, :3, :3] = (
            self.variant.scale * Rotation.from_quat(quaternion.multiply(self.up, self.own)).as_matrix()
        )
        matrices[:, :3, 3] = quaternion.rotate(self.up, places) / self.variant.unit
        if self.variant.bind == "pose":
            self.objects += [
                f'Pose: {POSE}, "Pose::bind", "BindPose" {{',
                'Type: "BindPose"',
                f"NbPoseNodes: {self.count}",
            ]
            for joint, matrix in enumerate(matrices):
                self.objects += ["PoseNode: {", f"Node: {joint_id(joint)}", *_array("Matrix", matrix.T.ravel()), "}"]
            self.objects.append("}")
            return
        triangle = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        self.objects.append(f'Geometry: {GEOMETRY}, "Geometry::body", "Mesh" {{')
        self.objects += [*_array("Vertices", triangle), *_array("PolygonVertexIndex", [0, 1, -3]), "}"]
        self._model(MESH, "body", "Mesh", 0, {})
        self.objects += [f'Deformer: {SKIN}, "Deformer::", "Skin" {{', "Version: 101", "}"]
        self.connections += [f'C: "OO",{GEOMETRY},{MESH}', f'C: "OO",{SKIN},{GEOMETRY}']
        for joint, matrix in enumerate(matrices):
            cluster = joint_id(joint) + 2
            self.objects += [
                f'Deformer: {cluster}, "SubDeformer::", "Cluster" {{',
                "Version: 100",
                *_array("Indexes", [0]),
                *_array("Weights", [1.0]),
                *_array("Transform", np.linalg.inv(matrix).T.ravel()),
                *_array("TransformLink", matrix.T.ravel()),
                "}",
            ]
            self.connections += [f'C: "OO",{cluster},{SKIN}', f'C: "OO",{joint_id(joint)},{cluster}']

    def _stack(self, number: int, clip: Clip) -> None:
        base = 10_000_000 * (number + 1)
        stop = round((clip.frame_count - 1) / clip.rate * SECOND)
        self.objects += [
            f'AnimationStack: {base}, "AnimStack::{clip.name}", "" {{',
            "Properties70: {",
            'P: "LocalStart", "KTime", "Time", "",0',
            f'P: "LocalStop", "KTime", "Time", "",{stop}',
            "}",
            "}",
            f'AnimationLayer: {base + 1}, "AnimLayer::{clip.name}", "" {{',
            "}",
        ]
        self.connections.append(f'C: "OO",{base + 1},{base}')
        translations, angles = self._local(clip)
        times = [round(frame / clip.rate * SECOND) for frame in range(clip.frame_count)]
        for joint in range(self.count):
            at = base + 100 + 10 * joint
            self._curves(at, base + 1, joint, "R", "Lcl Rotation", times, angles[:, joint])
            if joint == 0:
                self._curves(at + 5, base + 1, joint, "T", "Lcl Translation", times, translations[:, joint])

    def _curves(self, at: int, layer: int, joint: int, name: str, moves: str, times: list[int], values: Floats) -> None:
        self.objects += [f'AnimationCurveNode: {at}, "AnimCurveNode::{name}", "" {{', "}"]
        self.connections += [f'C: "OO",{at},{layer}', f'C: "OP",{at},{joint_id(joint)}, "{moves}"']
        for axis, letter in enumerate("XYZ"):
            self.objects += [
                f'AnimationCurve: {at + 1 + axis}, "AnimCurve::", "" {{',
                "KeyVer: 4008",
                *_array("KeyTime", times),
                *_array("KeyValueFloat", values[:, axis]),
                *_array("KeyAttrFlags", [LINEAR]),
                *_array("KeyAttrDataFloat", [0, 0, 0, 0]),
                *_array("KeyAttrRefCount", [len(times)]),
                "}",
            ]
            self.connections.append(f'C: "OP",{at + 1 + axis},{at}, "d|{letter}"')


def joint_id(joint: int) -> int:
    """Returns the number of a joint's model; its node attribute has the next one, its cluster the one after."""
    return 100 + 10 * joint


def _degrees(turns: Floats) -> Floats:
    """Euler angles about X, then Y, then Z, in degrees."""
    return Rotation.from_quat(turns.reshape(-1, 4)).as_euler("xyz", degrees=True).reshape(*turns.shape[:-1], 3)


def _array(name: str, values: Iterable[float]) -> list[str]:
    listed = list(values)
    return [f"{name}: *{len(listed)} {{", f"a: {_numbers(listed)}", "}"]


def _numbers(values: Iterable[float]) -> str:
    return ",".join(repr(float(value)) if not isinstance(value, int) else str(value) for value in values)
