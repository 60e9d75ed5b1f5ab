"""Splices by a kernel that takes each array as an argument, not one handle (`motionsplice.runtime.simd.handle`)."""

from __future__ import annotations

from collections.abc import Sequence

from bench.rounds import Work
from motionsplice.runtime.evaluator import NO_MEMORY, Evaluator
from motionsplice.runtime.kernels.arrays import BankArrays, Scratch
from motionsplice.runtime.kernels.evaluate import evaluate_part, first_at_fault
from motionsplice.runtime.requests import Requests
from motionsplice.runtime.simd.compiled import Array, kernel


@kernel
def evaluate(
    bank: BankArrays, scratch: Scratch, requests: Array, memory: Array, share: float, roots: Array, rotations: Array
) -> int:
    """As `motionsplice.runtime.kernels.evaluate.evaluate`."""
    fault = first_at_fault(bank, requests, len(memory) > 0)
    if fault < 0:
        evaluate_part(bank, requests, memory, share, scratch, 0, 0, len(requests), roots, rotations)
    return fault


def evaluation(evaluator: Evaluator, sets: Sequence[Requests]) -> Work:
    """Work that evaluates one set of requests per round into its own poses."""
    poses = evaluator.poses(len(sets[0]))
    rest = NO_MEMORY.state, NO_MEMORY.share, poses.root_positions, poses.flat
    return lambda number: evaluate(evaluator.arrays, evaluator.scratch, sets[number % len(sets)].records, *rest)
