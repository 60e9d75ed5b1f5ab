"""A VRM 1.0 character for tests: in a T-pose, of its own proportions, with local axes that differ from bone to bone."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from motionsplice.motion import quaternion
from motionsplice.motion.formats.gltf.document import ASSET, Binary, Document, glb

MIDDLE = {
    "hips": (None, (0.0, 1.0, 0.0)),
    "spine": ("hips", (0.0, 1.1, 0.01)),
    "chest": ("spine", (0.0, 1.25, 0.0)),
    "upperChest": ("chest", (0.0, 1.35, 0.0)),
    "neck": ("upperChest", (0.0, 1.5, 0.0)),
    "head": ("neck", (0.0, 1.6, 0.02)),
}
LEFT = {
    "Shoulder": ("upperChest", (0.03, 1.45, 0.0)),
    "UpperArm": ("Shoulder", (0.15, 1.45, 0.0)),
    "LowerArm": ("UpperArm", (0.42, 1.45, 0.0)),
    "Hand": ("LowerArm", (0.66, 1.45, 0.0)),
    "UpperLeg": ("hips", (0.1, 0.95, 0.0)),
    "LowerLeg": ("UpperLeg", (0.1, 0.5, 0.0)),
    "Foot": ("LowerLeg", (0.1, 0.08, 0.0)),
    "Toes": ("Foot", (0.1, 0.02, 0.14)),
    "ThumbMetacarpal": ("Hand", (0.69, 1.45, 0.03)),
    "ThumbProximal": ("ThumbMetacarpal", (0.72, 1.45, 0.06)),
    "ThumbDistal": ("ThumbProximal", (0.74, 1.45, 0.08)),
}
for finger, z in (("Index", 0.03), ("Middle", 0.01), ("Ring", -0.01), ("Little", -0.03)):
    LEFT[f"{finger}Proximal"] = ("Hand", (0.75, 1.45, z))
    LEFT[f"{finger}Intermediate"] = (f"{finger}Proximal", (0.79, 1.45, z))
    LEFT[f"{finger}Distal"] = (f"{finger}Intermediate", (0.81, 1.45, z))


def bones() -> dict[str, tuple[str | None, Any]]:
    """Returns the parent and the world position of each bone, parent before child."""
    found: dict[str, tuple[str | None, Any]] = dict(MIDDLE)
    for side, mirror in (("left", 1.0), ("right", -1.0)):
        for name, (parent, place) in LEFT.items():
            above = parent if parent in MIDDLE else f"{side}{parent}"
            found[f"{side}{name}"] = above, np.array(place) * (mirror, 1.0, 1.0)
    return found


def vrm_character(seed: int = 0) -> bytes:
    """Returns the file of a character without a mesh."""
    listed = bones()
    names = list(listed)
    turned = dict(zip(names, Rotation.random(len(names), random_state=seed).as_quat(), strict=True))
    nodes: list[dict[str, Any]] = []
    for name, (parent, place) in listed.items():
        above = quaternion.conjugate(turned[parent]) if parent else quaternion.IDENTITY
        offset = np.array(place) - (np.array(listed[parent][1]) if parent else 0.0)
        translation, rotation = quaternion.rotate(above, offset), quaternion.multiply(above, turned[name])
        nodes.append({"name": f"J_{name}", "translation": translation.tolist(), "rotation": rotation.tolist()})
        if parent:
            nodes[names.index(parent)].setdefault("children", []).append(len(nodes) - 1)
    human = {name: {"node": node} for node, name in enumerate(names)}
    meta = {"name": "test", "authors": ["test"], "licenseUrl": "https://vrm.dev/licenses/1.0/"}
    document: Document = {
        "asset": ASSET,
        "extensionsUsed": ["VRMC_vrm"],
        "extensions": {"VRMC_vrm": {"specVersion": "1.0", "meta": meta, "humanoid": {"humanBones": human}}},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
    }
    binary = Binary(document)
    binary.add(np.zeros((1, 3)))
    return glb(document, binary.data)
