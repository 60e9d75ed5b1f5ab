"""The parts of characters: state, commands, transitions, masks, mixing and root motion.

Kernels follow the rules of `runtime.kernels`; a step takes constant time.
"""
