"""Benchmarks of the alignment of hands to bodies."""
