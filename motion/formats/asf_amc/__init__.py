"""Acclaim skeletons (ASF) and motions (AMC), such as those of the CMU database."""

from __future__ import annotations

from motionsplice.motion.formats.asf_amc.motion import parse_motion
from motionsplice.motion.formats.asf_amc.skeleton import parse_skeleton

__all__ = ["parse_motion", "parse_skeleton"]
