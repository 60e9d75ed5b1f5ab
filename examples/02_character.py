"""Plays a character from second to second: transitions, an action, its events and its root motion."""

from pathlib import Path

import motionsplice
from motionsplice import EVENT_NAMES, Action

RATE = 60.0

folder = Path("example")
motionsplice.write_sample_clips(folder / "clips")
motionsplice.build_bank([folder / "clips"], folder / "bank", baseline="walk")

evaluator = motionsplice.Evaluator(motionsplice.Bank.open(folder / "bank"))
characters = motionsplice.Characters(motionsplice.Stage(evaluator), RATE)
(hero,) = characters.add(1, "walk")
poses = evaluator.poses(1)

for frame in range(int(8.0 * RATE)):
    seconds = frame / RATE
    if seconds == 1.0:
        characters.act([hero], Action("wave", when="left_foot", loop=False))  # waits for the left foot to touch down
    if seconds == 4.0:
        characters.play([hero], "run", blend=0.5)  # enters in step
    characters.evaluate(poses)
    happened = characters.advance()
    for bit, name in EVENT_NAMES.items():
        if happened & bit and name.startswith("action"):
            x, _, z = poses.root_positions[hero]
            print(f"{seconds:5.2f} s: {name} at x {x:.2f} m, z {z:.2f} m")
