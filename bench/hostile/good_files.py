"""Good files of each kind, small ones that use much of their format, from which hostile files are made."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from bench.hostile.damage import Damage, damage_bytes, damage_gltf, damage_text
from bench.hostile.rich_gltf import rich_document
from bench.hostile.small_rig import on_few_joints
from motionsplice.motion.clip import Clip
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.files import GLTF
from motionsplice.motion.formats.gltf.container import read_document
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.procedural.library import make

FRAMES = 12
LIMITED = 4  # joints up to this one have limits
LARGEST = 2_000_000  # bytes of a file of the user's that is damaged
HUMANOID = {
    "hips": "Hips",
    "head": "Head",
    "leftUpperLeg": "LeftUpLeg",
    "leftLowerLeg": "LeftLeg",
    "leftFoot": "LeftFoot",
    "rightUpperLeg": "RightUpLeg",
}
ASF = """:version 1.10
:name walk
:units
  mass 1.0
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
{bones}
:hierarchy
  begin
{pairs}
  end
"""
BONE = """  begin
    id {id}
    name {name}
    direction {x:.6f} {y:.6f} {z:.6f}
    length {length:.6f}
    axis 0 0 20 XYZ
{dof}
  end"""
DOF = "    dof rx ry rz"
LIMITS = """
    limits (-160 20)
           (-70 70)
           (-60 inf)"""
SUFFIXES = {"gltf": GLTF, "bvh": (".bvh",), "amc": (".amc",), "fbx": (".fbx",)}
DAMAGES: dict[str, tuple[Damage, ...]] = {
    "gltf": (damage_gltf, damage_gltf, damage_gltf, damage_bytes),
    "bvh": (damage_text, damage_text, damage_bytes),
    "amc": (damage_text, damage_text, damage_bytes),
    "fbx": (damage_bytes, damage_text),
}


@dataclass(frozen=True)
class Good:
    """A motion file by name, with the file that it needs beside it, if any; the first is the motion."""

    files: dict[str, bytes]

    @property
    def name(self) -> str:
        return next(iter(self.files))


def good_files(kind: str, folder: Path | None) -> list[Good]:
    """Returns built-in files of a kind, and those in a folder; for FBX there are none but those."""
    clip = on_few_joints(make("walk", "wave", seed=1, seconds=1.0).frames(0, FRAMES))
    makers = {"gltf": _gltf_files, "bvh": _bvh_files, "amc": _amc_files}
    made = makers[kind](clip) if kind in makers else []
    return made + [
        Good({file.name: file.read_bytes()})
        for file in (sorted(folder.iterdir()) if folder else ())
        if file.suffix.lower() in SUFFIXES[kind] and file.stat().st_size <= LARGEST
    ]


def hostile(kind: str, goods: list[Good], draw: Random) -> Good:
    """Returns one of the files, damaged."""
    good = draw.choice(goods)
    name = draw.choice(list(good.files))
    same = [
        other.files[theirs] for other in goods for theirs in other.files if Path(theirs).suffix == Path(name).suffix
    ]
    damage = draw.choice(DAMAGES[kind])
    return Good(good.files | {name: damage(good.files[name], draw.choice(same), draw)})


def _bvh_files(clip: Clip) -> list[Good]:
    return [Good({"walk.bvh": dump_bvh(clip)}), Good({"short.bvh": dump_bvh(clip.frames(0, 1))})]


def _amc_files(clip: Clip) -> list[Good]:
    """For each joint a stiff bone that leads to it, and one without length that turns."""
    bones, pairs = [], []
    skeleton = clip.skeleton
    for joint in range(1, skeleton.joint_count):
        name, above = skeleton.names[joint], int(skeleton.parents[joint])
        length = float(np.linalg.norm(skeleton.offsets[joint]))
        x, y, z = skeleton.offsets[joint] / length
        bones.append(BONE.format(id=2 * joint, name=f"to{name}", x=x, y=y, z=z, length=length, dof=""))
        dof = DOF + LIMITS * (joint < LIMITED)
        bones.append(BONE.format(id=2 * joint + 1, name=name, x=0.0, y=1.0, z=0.0, length=0.0, dof=dof))
        pairs += [f"    {skeleton.names[above] if above else 'root'} to{name}", f"    to{name} {name}"]
    asf = ASF.format(bones="\n".join(bones), pairs="\n".join(pairs))
    frames = [":FULLY-SPECIFIED", ":DEGREES"]
    for frame in range(FRAMES):
        frames += [str(frame + 1), f"root 0 17.{frame} 0 1 2 {frame}"]
        frames += [f"{name} {10 + frame} 2.5 -3" for name in skeleton.names[1:]]
    return [Good({"walk.amc": "\n".join(frames).encode(), "walk.asf": asf.encode()})]


def _gltf_files(clip: Clip) -> list[Good]:
    plain = dump_glb(clip)
    document, binary = read_document(plain)
    return [
        Good({"walk.glb": plain}),
        Good({"walk.gltf": with_data(document, binary)}),
        Good({"rich.gltf": with_data(*rich_document(clip))}),
        Good({"walk.vrma": with_data(_with_humanoid(document), binary)}),
    ]


def _with_humanoid(document: dict[str, Any]) -> dict[str, Any]:
    names = [node.get("name") for node in document["nodes"]]
    bones = {bone: {"node": names.index(joint)} for bone, joint in HUMANOID.items()}
    return document | {"extensions": {"VRMC_vrm_animation": {"specVersion": "1.0", "humanoid": {"humanBones": bones}}}}


def with_data(document: dict[str, Any], binary: bytes) -> bytes:
    """Returns a document that holds its own buffer."""
    uri = f"data:application/octet-stream;base64,{base64.b64encode(binary).decode()}"
    return json.dumps(document | {"buffers": [{"byteLength": len(binary), "uri": uri}]}).encode()
