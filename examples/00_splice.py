"""Builds a bank, splices an action onto a locomotion, and writes the motion as BVH."""

from pathlib import Path

import motionsplice

folder = Path("example")
motionsplice.write_sample_clips(folder / "clips")  # use a folder of your own BVH or ASF/AMC files instead

outcome = motionsplice.build_bank([folder / "clips"], folder / "bank", baseline="walk")
for name, error in outcome.failed.items():
    print(f"{name} was left out: {error}")

bank = motionsplice.Bank.open(folder / "bank")
evaluator = motionsplice.Evaluator(bank)

clip = evaluator.clip(motionsplice.Splice("curve", "carry_box"))
(folder / "curve+carry_box.bvh").write_bytes(motionsplice.dump_bvh(clip))
print(f"{folder / 'curve+carry_box.bvh'}: {clip.frame_count} frames at {clip.rate:g} per second")
