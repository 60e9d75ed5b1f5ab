"""What a game does with splices: state, commands, transitions, masks and root motion.

Imported by `character` and `stage`.

Kernels follow the rules of `runtime.kernels`; a step takes constant time.
"""
