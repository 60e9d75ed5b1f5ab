"""The stage: the bank-wide arrays that characters share."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.characters import clock_kernels, pose_kernels
from motionsplice.runtime.characters.arrays import CLOCK_SIZE, StageArrays, ground, mixing
from motionsplice.runtime.characters.chains import chains_of
from motionsplice.runtime.characters.legs import legs_of
from motionsplice.runtime.characters.limbs import limbs_of
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.simd.entry import entry_of
from motionsplice.runtime.simd.handle import handle_of


class Stage:
    """Everything that characters on one bank share: the evaluator, and arrays for root motion, masks, aims and mixing.

    A stage owns scratch memory, as does its evaluator, so threads must not share it.

    Args:
        evaluator: The evaluator.

    Attributes:
        evaluator: The evaluator.
        bank: Its bank.
        arrays: The bank and its rig as flat arrays for kernels.
    """

    def __init__(self, evaluator: Evaluator) -> None:
        bank = evaluator.bank
        self.evaluator = evaluator
        self.bank: Bank = bank
        self.arrays = StageArrays(
            bank=evaluator.arrays,
            ground=ground(bank),
            limbs=limbs_of(bank.skeleton, bank.roles, bank.layout),
            chains=chains_of(bank),
            legs=legs_of(bank.skeleton, bank.roles),
            scratch=evaluator.scratch,
            mixing=mixing(bank.layout),
            clock=np.zeros(CLOCK_SIZE),
        )
        self._handle = handle_of(self.arrays)

    @cached_property
    def _advance(self) -> Callable[..., int]:
        """The kernel that advances characters. `Characters` checks their state where it comes from outside."""
        return entry_of(clock_kernels.advance, self._handle, np.zeros(0), 0.0)

    @cached_property
    def _evaluate(self) -> Callable[..., None]:
        """The kernel that evaluates characters."""
        out = self.evaluator.poses(0)
        return entry_of(pose_kernels.evaluate_characters, self._handle, np.zeros(0), 0.0, out.root_positions, out.flat)

    def __reduce__(self) -> tuple[type[Stage], tuple[Evaluator]]:
        """Copies and pickles are made anew, as those of the evaluator."""
        return type(self), (self.evaluator,)
