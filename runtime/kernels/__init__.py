"""One splice of one frame, compiled. Imported by the evaluator and by `characters`, of which nothing here knows.

Kernels check nothing, allocate nothing and hold no GIL: `Requests` and commands are checked at the door. Each kernel
has a slow, readable twin in `tests/`.
"""
