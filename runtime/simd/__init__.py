"""Compilation for the processor: kernels, vector lanes, prefetching. Independent of animation."""
