"""Compiled kernels: one splice of one frame. Used by the evaluator and by `characters`, and independent of both.

Kernels check nothing, allocate nothing and release the GIL. Their inputs are checked before: requests by the evaluator,
commands by `Characters`. Each kernel has a slow, readable twin in `tests/`.
"""
