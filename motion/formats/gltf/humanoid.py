"""The humanoid map of VRM 0.x, VRM 1.0 and VRM animations: which node is which bone of a person."""

from __future__ import annotations

from typing import Any

SIDED = {
    "UpperLeg": "hip", "LowerLeg": "knee", "Foot": "ankle", "Toes": "toe", "UpperArm": "shoulder",
    "LowerArm": "elbow", "Hand": "wrist",
}  # fmt: skip
ROLES = {f"{side}{bone}": f"{side}_{role}" for side in ("left", "right") for bone, role in SIDED.items()} | {
    "neck": "neck",
    "head": "head",
}


def human_bones(document: dict[str, Any]) -> dict[str, int]:
    """Returns the nodes of all bones of a person by VRM's names of bones; none if the file has no such map."""
    extensions = document.get("extensions", {})
    for name in ("VRMC_vrm", "VRMC_vrm_animation"):
        if bones := extensions.get(name, {}).get("humanoid", {}).get("humanBones", {}):
            return {bone: int(one["node"]) for bone, one in bones.items()}
    bones = extensions.get("VRM", {}).get("humanoid", {}).get("humanBones", [])
    return {one["bone"]: int(one["node"]) for one in bones}


def humanoid_nodes(document: dict[str, Any]) -> dict[str, int]:
    """Returns the nodes of the limbs, neck and head by role; none if the file has no such map."""
    return {ROLES[bone]: node for bone, node in human_bones(document).items() if bone in ROLES}
