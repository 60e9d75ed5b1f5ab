"""A bank as characters play on it: what their kernels need beside the evaluator."""

from __future__ import annotations

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters.arrays import ground, mixing
from motionsplice.runtime.characters.limbs import limbs_of
from motionsplice.runtime.evaluator import Evaluator


class Stage:
    """A bank as characters play on it. Not to be shared between threads, as the evaluator."""

    def __init__(self, evaluator: Evaluator) -> None:
        bank = evaluator.bank
        self.evaluator = evaluator
        self.bank: Bank = bank
        self.ground = ground(bank)
        self.limbs = limbs_of(bank.skeleton, bank.roles, bank.layout)
        self.mixing = mixing(bank.layout)
