"""What the characters of a stream play: pairs of a generated bank's clips, from random times on."""

from __future__ import annotations

import numpy as np

from bench.generated import Size
from bench.service.player import Command

BANK = Size()  # of the bank that the service is measured on
CHARACTERS = "/v1/characters"


def clip_names(size: Size = BANK) -> list[str]:
    """The names of a generated bank's clips."""
    return [f"clip{number:05d}" for number in range(size.clips)]


def cast(count: int, seed: int) -> list[Command]:
    """Commands that make `count` characters, in as many groups as there are clips at most: each plays a pair."""
    random, names = np.random.default_rng(seed), clip_names()
    commands: list[Command] = []
    for ids in np.array_split(np.arange(count), min(count, len(names))):
        locomotion, action = (names[number] for number in random.choice(len(names), 2, replace=False))
        who, time = ids.tolist(), round(BANK.seconds * float(random.random()), 3)
        commands.append({"do": "create", "id": who, "locomotion": locomotion, "time": time})
        commands.append({"do": "act", "id": who, "action": action})
    return commands
