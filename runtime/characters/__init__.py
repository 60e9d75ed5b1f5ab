"""The parts of characters: state, commands, transitions, masks, mixing and root motion.

Used by `character` and `stage`. Kernels follow the rules of `runtime.kernels`; a step takes constant time.
"""
