"""Which joint of a rig is the root, the pelvis, a knee, a shoulder ..."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from motionsplice.motion.errors import RoleError, SettingsError, did_you_mean
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.role_names import OPTIONAL, PAIRED, roles_by_name
from motionsplice.motion.skeleton import Integers, Skeleton, chain

GivenRole = str | Sequence[str]  # the name of a joint, or for the spine of several
NOTHING_GIVEN: Mapping[str, GivenRole] = MappingProxyType({})
LIMBS = tuple(f"{side}_{role}" for role in PAIRED if role != "toe" for side in ("left", "right"))
ENDS = ("left_hip", "right_hip", "left_shoulder", "right_shoulder")


@dataclass(frozen=True)
class Roles:
    """Joint indices by role. The pelvis is where the upper body hangs on the root.

    `spine` runs from the pelvis's child up to the joint at which the two arms part, so it may be empty.
    `neck`, `head` and the toes are -1 on rigs that have none.
    """

    root: int
    pelvis: int
    spine: tuple[int, ...]
    neck: int
    head: int
    left_hip: int
    left_knee: int
    left_ankle: int
    left_toe: int
    right_hip: int
    right_knee: int
    right_ankle: int
    right_toe: int
    left_shoulder: int
    left_elbow: int
    left_wrist: int
    right_shoulder: int
    right_elbow: int
    right_wrist: int

    @property
    def lower_cloud(self) -> tuple[int, ...]:
        """The joints that time alignment looks at (Heck et al. 2006, 3.1)."""
        return (self.root, self.left_knee, self.right_knee)

    @property
    def upper_cloud(self) -> tuple[int, ...]:
        """The joints that spatial alignment looks at, the pelvis itself apart (Heck et al. 2006, 3.2)."""
        return (*self.spine, self.left_shoulder, self.right_shoulder)

    @property
    def feet(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Ankle and toe, if the rig has one, of the left and the right foot."""
        left, right = (self.left_ankle, self.left_toe), (self.right_ankle, self.right_toe)
        return tuple(one for one in left if one >= 0), tuple(one for one in right if one >= 0)

    def leg_length(self, skeleton: Skeleton) -> float:
        """Metres from hip over knee to ankle, mean of both legs."""
        ends = ((self.left_hip, self.left_ankle), (self.right_hip, self.right_ankle))
        bones = [joint for hip, ankle in ends for joint in _between(skeleton, hip, ankle)]  # twist bones included
        return sum(skeleton.bone_length(joint) for joint in bones) / 2.0


def find_roles(skeleton: Skeleton, given: Mapping[str, GivenRole] = NOTHING_GIVEN) -> Roles:
    """The roles of a rig, as `given` by joint name, else found by the names of the limbs and the shape of the tree.

    The root must be joint 0 (`motion.formats.fold` sees to that). Raises RoleError if a role cannot be found, with
    all joints, what was found, and a file to fill in; SettingsError for a role that there is not.
    """
    found = limbs_by_name(skeleton.names, given)
    if missing := [role for role in LIMBS if role not in found]:
        raise RoleError(
            f"no joint was found for {', '.join(missing)}. The joints are {', '.join(skeleton.names)}. "
            f"Found were {', '.join(f'{role} = {skeleton.names[at]}' for role, at in found.items()) or 'none'}",
            mend=f"Name the missing ones in a file and pass it as --roles:\n\n{_stub(missing)}",
        )
    root = common_ancestor(skeleton.parents, [found[role] for role in ENDS])
    chest = common_ancestor(skeleton.parents, [found["left_shoulder"], found["right_shoulder"]])
    if root != 0 or chest == root:
        problem = f"legs and arms part at {skeleton.names[root]!r} and {skeleton.names[chest]!r}, so there is no trunk"
        raise RoleError(problem, mend="Name the joints of the legs and arms in a file and pass it as --roles")
    way = skeleton.chain(chest)
    pelvis = way[way.index(root) - 1]
    if "pelvis" in given:
        pelvis = _joint("pelvis", given["pelvis"], skeleton.names)
    trunk = way[: way.index(pelvis)][::-1] if pelvis in way else []
    spine = given.get("spine", tuple(skeleton.names[joint] for joint in trunk))
    trunk = [_joint("spine", name, skeleton.names) for name in ((spine,) if isinstance(spine, str) else spine)]
    limbs = {role: found.get(role, -1) for role in (*LIMBS, *OPTIONAL)}
    for side in ("left", "right"):
        for limb in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")):
            upper, middle, lower = (found[f"{side}_{joint}"] for joint in limb)
            if upper not in skeleton.chain(middle)[1:] or middle not in skeleton.chain(lower)[1:]:
                problem = f"the {side} {limb[0]}, {limb[1]} and {limb[2]} do not hang on each other in this order"
                raise RoleError(problem, mend="Name them again in a file and pass it as --roles")
    if pelvis == root or pelvis not in way:
        problem = f"the pelvis {skeleton.names[pelvis]!r} does not lie between the root and the arms"
        raise RoleError(problem, mend="Leave it out, or name a joint of the trunk")
    return Roles(root=root, pelvis=pelvis, spine=tuple(trunk), **limbs)


def limbs_by_name(names: tuple[str, ...], given: Mapping[str, GivenRole]) -> dict[str, int]:
    """The joint of each limb, of neck and head, as given or by name. Raises RoleError for a joint that is not there."""
    _check_known(given)
    found = roles_by_name(names)
    return found | {role: _joint(role, name, names) for role, name in given.items() if role in (*LIMBS, *OPTIONAL)}


def common_ancestor(parents: Integers, joints: Sequence[int]) -> int:
    """The lowest joint that all of `joints` hang on."""
    chains = [chain(parents, joint) for joint in joints]
    shared = set(chains[0]).intersection(*chains[1:])
    return next(joint for joint in chains[0] if joint in shared)


def check_shape(positions: Floats, roles: Roles) -> None:
    """Raises RoleError unless roles fit how a body moves, in most frames [F, J, 3]: knees below hips, shoulders above
    the pelvis, and left and right on the same sides above and below."""
    where = np.median(positions - positions[:, :1], axis=0)
    hips = positions[:, roles.left_hip] - positions[:, roles.right_hip]
    shoulders = positions[:, roles.left_shoulder] - positions[:, roles.right_shoulder]
    for problem, sound in {
        "the left knee is above the left hip": where[roles.left_knee, 1] < where[roles.left_hip, 1],
        "the right knee is above the right hip": where[roles.right_knee, 1] < where[roles.right_hip, 1],
        "the left shoulder is below the pelvis": where[roles.left_shoulder, 1] > where[roles.pelvis, 1],
        "the right shoulder is below the pelvis": where[roles.right_shoulder, 1] > where[roles.pelvis, 1],
        "left and right are crossed between hips and shoulders": np.median(np.sum(hips * shoulders, axis=1)) > 0.0,
    }.items():
        if not sound:
            raise RoleError(
                f"the roles do not fit the body: {problem}",
                mend="Is the file Y up? If so, name the joints in a file and pass it as --roles",
            )


def read_roles_file(file: Path) -> dict[str, GivenRole]:
    """The `[roles]` of a TOML file, joint names by role. Raises SettingsError, naming the file and the key."""
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise SettingsError(f"it cannot be read: {error.strerror}", file=str(file)) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SettingsError(f"it is not TOML: {error}", file=str(file)) from None
    roles = document.get("roles")
    if not isinstance(roles, dict) or set(document) != {"roles"}:
        raise SettingsError("it needs one table, [roles]", file=str(file), mend='Write [roles] and left_hip = "..."')
    try:
        _check_known(roles)
    except SettingsError as error:
        raise error.within(str(file)) from None
    for role, name in roles.items():
        names = name if isinstance(name, list) and role == "spine" else [name]
        if not all(isinstance(one, str) for one in names):
            raise SettingsError(f"{role} = {name!r} is not the name of a joint", file=str(file))
    return roles


def _check_known(given: Mapping[str, GivenRole]) -> None:
    known = (*LIMBS, *OPTIONAL, "pelvis", "spine")
    for role in given:
        if role not in known:
            raise SettingsError(f"unknown role {role!r}", mend=did_you_mean(role, known))


def _joint(role: str, name: GivenRole, names: tuple[str, ...]) -> int:
    if name not in names:
        raise RoleError(f"{role} is given as {name!r}, which is no joint", mend=did_you_mean(str(name), names))
    return names.index(str(name))


def _between(skeleton: Skeleton, upper: int, lower: int) -> list[int]:
    """The joints from `lower` up to `upper`, without it."""
    way = skeleton.chain(lower)
    return way[: way.index(upper)]


def _stub(missing: Sequence[str]) -> str:
    return "[roles]\n" + "\n".join(f'{role} = ""' for role in missing)
