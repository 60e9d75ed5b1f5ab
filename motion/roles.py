"""Roles: which joint of a rig is the root, the pelvis, a knee, a shoulder ..."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType
from typing import Literal

from motionsplice.motion.animals import not_human
from motionsplice.motion.errors import RoleError, SettingsError, did_you_mean
from motionsplice.motion.role_names import OPTIONAL, PAIRED, roles_by_name
from motionsplice.motion.skeleton import Integers, Skeleton, chain
from motionsplice.motion.storage.place import Place
from motionsplice.motion.toml_file import read_toml

Side = Literal["left", "right"]
SIDES: tuple[Side, ...] = ("left", "right")
LEG, ARM = ("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")
GivenRole = str | Sequence[str]  # a joint's name; for the spine also several
NOTHING_GIVEN: Mapping[str, GivenRole] = MappingProxyType({})
LIMBS = tuple(f"{side}_{role}" for role in PAIRED if role != "toe" for side in SIDES)
ROLES_FILE = "a file, and pass it as --roles, or set it as `roles` of this clip in clips.toml"
ENDS = ("left_hip", "right_hip", "left_shoulder", "right_shoulder")


@dataclass(frozen=True)
class Roles:
    """The joint indices of a rig by role. `neck`, `head` and the toes are -1 on rigs without them.

    Attributes:
        root: The joint at which the legs and the trunk branch; always joint 0.
        pelvis: The joint by which the upper body hangs on the root, by default the root's child (`LowerBack` on CMU
            rigs, `Spine` on Mixamo, `spine_01` on Unreal). It is never the root itself.
        spine: The joints from the pelvis's child up to the joint at which the arms branch, in this order. Empty if the
            arms branch at the pelvis.
        neck: The lowest joint of the neck.
        head: The head.
        left_hip: The left hip. The other joints of legs and arms are named alike, left and right: knee, ankle, toe,
            shoulder, elbow and wrist.
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
        """The joints that time alignment compares: root and knees (Heck et al. 2006, 3.1)."""
        return (self.root, self.left_knee, self.right_knee)

    @property
    def upper_cloud(self) -> tuple[int, ...]:
        """The joints that spatial alignment compares, besides the pelvis (Heck et al. 2006, 3.2)."""
        return (*self.spine, self.left_shoulder, self.right_shoulder)

    @property
    def feet(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The joints of the left and of the right foot: the ankle, and the toe if the rig has one."""
        left, right = (self.left_ankle, self.left_toe), (self.right_ankle, self.right_toe)
        return tuple(joint for joint in left if joint >= 0), tuple(joint for joint in right if joint >= 0)

    def leg_length(self, skeleton: Skeleton) -> float:
        """Returns the length in metres from hip over knee to ankle, as the mean of both legs."""
        return _leg_length(self, skeleton)


@lru_cache(maxsize=16)  # a clip's preparation asks ten times
def _leg_length(roles: Roles, skeleton: Skeleton) -> float:
    ends = ((roles.left_hip, roles.left_ankle), (roles.right_hip, roles.right_ankle))
    bones = [joint for hip, ankle in ends for joint in _between(skeleton, hip, ankle)]  # twist bones included
    return sum(skeleton.bone_length(joint) for joint in bones) / 2.0


def on_side(roles: Roles, side: Side, parts: Sequence[str]) -> tuple[int, ...]:
    """Returns the joints of parts of a leg or an arm, such as LEG or ARM, on one side; -1 for a missing toe."""
    return tuple(int(getattr(roles, f"{side}_{part}")) for part in parts)


def find_roles(skeleton: Skeleton, given: Mapping[str, GivenRole] = NOTHING_GIVEN) -> Roles:
    """Finds the roles of a rig's joints by their names and the shape of the hierarchy.

    Knows the joint names of the common rigs: Mixamo, Unreal, CMU, LAFAN1, VRM, Rigify, Biped, Daz, SMPL and others,
    with any prefix or suffix that all joints share.

    Args:
        skeleton: The rig. The root, at which legs and trunk branch, must be joint 0, as in clips from `read_clip`.
        given: Joint names by role, which take precedence over what is found: limbs such as "left_hip", "neck", "head",
            "left_toe", "right_toe", "pelvis", and "spine", for which several names may be given.

    Returns:
        The roles.

    Raises:
        RoleError: A role cannot be found, or the roles found do not form legs, arms and a trunk. The message lists all
            joints and the roles that were found, and has the text of a roles file to fill in, or says why this is not
            a human body.
        SettingsError: `given` has an unknown role.
    """
    found = limbs_by_name(skeleton.names, given)
    if missing := [role for role in LIMBS if role not in found]:
        raise _missing(skeleton, found, missing)
    root = common_ancestor(skeleton.parents, [found[role] for role in ENDS])
    chest = common_ancestor(skeleton.parents, [found["left_shoulder"], found["right_shoulder"]])
    if root != 0:
        problem = f"legs and arms branch at {skeleton.names[root]!r}, which is not joint 0"
        raise RoleError(problem, mend="Read the file with `read_clip`, which makes it joint 0")
    if chest == root:
        problem = f"no trunk found: arms and legs hang on one joint, {skeleton.names[root]!r}"
        mend = "This rig cannot be spliced. Export one with a joint between hips and arms, such as a spine"
        raise RoleError(problem, mend=mend)
    path = skeleton.chain(chest)
    pelvis = path[path.index(root) - 1]
    if "pelvis" in given:
        pelvis = _joint("pelvis", given["pelvis"], skeleton.names)
    trunk = path[: path.index(pelvis)][::-1] if pelvis in path else []
    spine = given.get("spine", tuple(skeleton.names[joint] for joint in trunk))
    trunk = [_joint("spine", name, skeleton.names) for name in ((spine,) if isinstance(spine, str) else spine)]
    limbs = {role: found.get(role, -1) for role in (*LIMBS, *OPTIONAL)}
    limbs |= _only_toes(skeleton, found)
    check_limbs(skeleton.names, skeleton.parents, found)
    if pelvis == root or pelvis not in path:
        problem = f"the pelvis {skeleton.names[pelvis]!r} is not between the root and the arms"
        raise RoleError(problem, mend="Name a joint of the trunk, or leave the pelvis out")
    return Roles(root=root, pelvis=pelvis, spine=tuple(trunk), **limbs)


def _only_toes(skeleton: Skeleton, found: Mapping[str, int]) -> dict[str, int]:
    """Returns the toes by role if they have unknown names but are the only joints that hang on the ankles."""
    if "left_toe" in found or "right_toe" in found:
        return {}
    below = {side: skeleton.children[found[f"{side}_ankle"]] for side in SIDES}
    return {f"{side}_toe": joints[0] for side, joints in below.items()} if {*map(len, below.values())} == {1} else {}


def limbs_by_name(names: tuple[str, ...], given: Mapping[str, GivenRole]) -> dict[str, int]:
    """Returns the joints of the limbs, neck and head by role, as given or else found by name.

    Raises RoleError for a given joint that the rig does not have, SettingsError for an unknown role.
    """
    _check_known(given)
    named = {role: _joint(role, name, names) for role, name in given.items() if role in (*LIMBS, *OPTIONAL)}
    return {**roles_by_name(names), **named}


def common_ancestor(parents: Integers, joints: Sequence[int]) -> int:
    """Returns the lowest joint that is an ancestor of all `joints`, or one of them; `parents` [J]."""
    chains = [chain(parents, joint) for joint in joints]
    shared = set(chains[0]).intersection(*chains[1:])
    return next(joint for joint in chains[0] if joint in shared)


def check_limbs(names: Sequence[str], parents: Integers, found: Mapping[str, int]) -> None:
    """Raises RoleError unless knees are below hips, ankles below knees, and so on, of the joints that were found."""
    for side in SIDES:
        for above, below in (*pairwise(LEG), *pairwise(ARM)):
            upper, lower = found.get(f"{side}_{above}"), found.get(f"{side}_{below}")
            if upper is not None and lower is not None and upper not in chain(parents, lower)[1:]:
                raise RoleError(
                    f"{names[lower]!r} ({side} {below}) is not below {names[upper]!r} ({side} {above})"
                    + (f", but hangs on {names[parents[lower]]!r}" if parents[lower] >= 0 else ""),
                    mend=f"If other joints are these, name them in {ROLES_FILE}. "
                    "If not, export a rig whose legs and arms are chains of joints",
                )


def read_roles_file(file: Place) -> dict[str, GivenRole]:
    """Reads a TOML file with one table, `[roles]`: joint names by role.

    Raises SettingsError if the file cannot be read or an entry is invalid. The message names the file and the key.
    """
    document = read_toml(file)
    roles = document.get("roles")
    if not isinstance(roles, dict) or set(document) != {"roles"}:
        mend = 'Write [roles], and below it one line for each role, such as left_hip = "LeftUpLeg"'
        raise SettingsError("expected one table, [roles]", file=str(file), mend=mend)
    try:
        _check_known(roles)
    except SettingsError as error:
        raise error.within(str(file)) from None
    for role, name in roles.items():
        names = name if isinstance(name, list) and role == "spine" else [name]
        if not all(isinstance(joint, str) for joint in names):
            problem = f"{role} = {name!r:.80} is not the name of a joint"
            raise SettingsError(problem, file=str(file), mend="Write the joint's name in quotes")
    return roles


def _check_known(given: Mapping[str, GivenRole]) -> None:
    known = (*LIMBS, *OPTIONAL, "pelvis", "spine")
    for role in given:
        if role not in known:
            raise SettingsError(f"unknown role {role!r:.80}", mend=did_you_mean(role, known))


def _joint(role: str, name: GivenRole, names: tuple[str, ...]) -> int:
    if name not in names:
        raise RoleError(f"unknown joint {name!r} for role {role}", mend=did_you_mean(str(name), names))
    return names.index(str(name))


def _between(skeleton: Skeleton, upper: int, lower: int) -> list[int]:
    """Returns the joints from `lower` up to `upper`, without `upper`."""
    path = skeleton.chain(lower)
    return path[: path.index(upper)]


def _missing(skeleton: Skeleton, found: Mapping[str, int], missing: Sequence[str]) -> RoleError:
    """Returns the error for roles without a joint, with a roles file to fill in if it may be a human body."""
    if difference := not_human(skeleton):
        problem = f"this is not a human body: {difference}"
        return RoleError(problem, mend=f"If it is one, name its joints in {ROLES_FILE}")
    return RoleError(
        f"no joint found for {', '.join(missing)}. Joints: {', '.join(skeleton.names)}. "
        f"Roles found: {', '.join(f'{role} = {skeleton.names[at]}' for role, at in found.items()) or 'none'}",
        mend=f"If it is a human body, name the missing joints in {ROLES_FILE}:\n\n[roles]\n"
        + "\n".join(f'{role} = ""' for role in missing),
    )
