"""The stage: the bank-wide arrays that characters share."""

from __future__ import annotations

import numpy as np

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters.arrays import CLOCK_SIZE, ground, mixing
from motionsplice.runtime.characters.chains import chains_of
from motionsplice.runtime.characters.legs import legs_of
from motionsplice.runtime.characters.limbs import limbs_of
from motionsplice.runtime.evaluator import Evaluator


class Stage:
    """Everything that characters on one bank share: the evaluator, and arrays for root motion, masks, aims and mixing.

    A stage owns scratch memory, as does its evaluator, so threads must not share it.

    Args:
        evaluator: The evaluator.

    Attributes:
        evaluator: The evaluator.
        bank: Its bank.
        ground: Root paths, foot contacts and feet of all rows of the bank.
        limbs: Joints of the parts of the upper body, for masks.
        chains: Chains of joints that turn toward targets, with scratch memory.
        legs: Joints of the legs, for the foot lock.
        mixing: Scratch memory for mixing.
        clock: Scratch memory for advancing.
    """

    def __init__(self, evaluator: Evaluator) -> None:
        bank = evaluator.bank
        self.evaluator = evaluator
        self.bank: Bank = bank
        self.ground = ground(bank)
        self.limbs = limbs_of(bank.skeleton, bank.roles, bank.layout)
        self.chains = chains_of(bank)
        self.legs = legs_of(bank.skeleton, bank.roles)
        self.mixing = mixing(bank.layout)
        self.clock = np.zeros(CLOCK_SIZE)
