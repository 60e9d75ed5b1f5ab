"""Evaluates a thousand characters a frame into arrays of your own."""

import time
from pathlib import Path

import numpy as np

import motionsplice

COUNT, FRAMES, RATE = 1000, 120, 60.0

folder = Path("example")
motionsplice.write_sample_clips(folder / "clips")
motionsplice.build_bank([folder / "clips"], folder / "bank", baseline="walk")

bank = motionsplice.Bank.open(folder / "bank")
evaluator = motionsplice.Evaluator(bank)
evaluator.warm()  # compiles the kernels the first time

draw = np.random.default_rng(0)
locomotions = [bank.number(clip.name) for clip in bank.clips if clip.kind == "locomotion"]
actions = [bank.number(clip.name) for clip in bank.clips if clip.kind == "action"]

# All that is needed is allocated here; the loop below creates no array and no object per character.
requests, poses = motionsplice.Requests.empty(COUNT), evaluator.poses(COUNT)
requests.locomotion[:] = draw.choice(locomotions, COUNT)
requests.action[:] = draw.choice(actions, COUNT)
durations = np.array([bank.clips[number].duration for number in requests.locomotion])
requests.time[:] = draw.random(COUNT) * durations

began = time.perf_counter()
for _ in range(FRAMES):
    evaluator.evaluate(requests, poses)  # poses.root_positions [n, 3] metres, poses.rotations [n, J, 4] xyzw
    requests.time += 1.0 / RATE
    np.mod(requests.time, durations, out=requests.time)
seconds = time.perf_counter() - began
print(f"{COUNT} characters of {bank.skeleton.joint_count} joints: {1e3 * seconds / FRAMES:.2f} ms a frame")
