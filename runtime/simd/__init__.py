"""Compiling for the processor: kernels, vector lanes, prefetching.

Knows nothing of animation; any kernel may import it.
"""
