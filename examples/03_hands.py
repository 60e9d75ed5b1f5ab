"""Lays hands that were captured separately on a body, in the body's own time."""

from pathlib import Path

import motionsplice

folder = Path("example")
motionsplice.write_sample_gestures(folder / "gestures")

body = motionsplice.read_clip(folder / "gestures" / "directions.bvh")
hands = motionsplice.read_clip(folder / "gestures" / "directions_hands.bvh")
spliced = motionsplice.splice_hands(body.clip, body.roles, hands.clip, hands.roles, motionsplice.HandSettings())

(folder / "directions+hands.bvh").write_bytes(motionsplice.dump_bvh(spliced.clip))
print(f"mismatch of gestures: {spliced.mismatch:.2f} (0 for identical ones, about 1 for unrelated ones)")
for warning in spliced.warnings:
    print(f"warning: {warning}")
