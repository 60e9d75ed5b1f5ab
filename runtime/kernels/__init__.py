"""Compiled kernels: one splice of one frame.

Kernels check nothing, allocate nothing and release the GIL. Their inputs are checked before: requests by the evaluator,
commands by `Characters`. Each kernel has a slow, readable twin in `tests/`.
"""
