"""Biovision Hierarchy (BVH) files: hierarchy, frames and writer."""

from __future__ import annotations

from motionsplice.motion.formats.bvh.hierarchy import CHANNELS
from motionsplice.motion.formats.bvh.reader import parse
from motionsplice.motion.formats.bvh.writer import dump_bvh, pieces

__all__ = ["CHANNELS", "dump_bvh", "parse", "pieces"]
