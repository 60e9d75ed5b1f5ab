"""Splices the upper body of any motion clip onto the lower body of any other, in constant time per frame."""

from motion.clip import Clip
from motion.errors import MotionError
from motion.formats.bvh import dump as dump_bvh
from motion.formats.files import read_clip
from motion.roles import Roles, find_roles
from motion.skeleton import Skeleton
from precompute.banded_warp import FramePair
from precompute.hand_settings import HandSettings
from precompute.hand_splice import splice_hands
from precompute.job import precompute
from precompute.splice import splice_exact, splice_naive
from runtime.bank import Bank
from runtime.character import Characters
from runtime.evaluator import Evaluator
from runtime.requests import Memory, Poses, Requests
from runtime.stage import Stage

__all__ = [
    "Bank",
    "Characters",
    "Clip",
    "Evaluator",
    "FramePair",
    "HandSettings",
    "Memory",
    "MotionError",
    "Poses",
    "Requests",
    "Roles",
    "Skeleton",
    "Stage",
    "dump_bvh",
    "find_roles",
    "precompute",
    "read_clip",
    "splice_exact",
    "splice_hands",
    "splice_naive",
]
