"""A bank as characters play on it: what their kernels need beside the evaluator."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import state as col
from motionsplice.runtime.characters.limbs import limbs_of
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.kernels import arrays
from motionsplice.runtime.requests import REQUEST


class Stage:
    """A bank as characters play on it. Not to be shared between threads, as the evaluator."""

    def __init__(self, evaluator: Evaluator) -> None:
        bank = evaluator.bank
        self.evaluator = evaluator
        self.bank: Bank = bank
        self.ground = arrays.ground(bank)
        self.limbs = limbs_of(bank.skeleton, bank.roles, bank.layout)
        width = max(bank.layout.lower.width, bank.layout.upper.width)
        self.mixing = arrays.Mixing(
            requests=np.zeros(arrays.BLOCK, REQUEST),
            memory=np.zeros((arrays.BLOCK, arrays.MEMORY_COLUMNS)),
            sum=np.zeros((4, width), np.float32),
            lane_weights=np.zeros((1, width), np.float32),
            row=np.zeros((2, bank.layout.lower.columns), np.float32),
            weights=np.zeros(col.PARTS * (col.MOST_ACTIONS + 2)),
            shares=np.zeros((arrays.BLOCK, col.PARTS)),
            kept=np.zeros((arrays.BLOCK, 4 * col.PARTS)),
            limbs_turn=np.zeros(arrays.BLOCK, np.int64),
        )
