"""Benchmarks of quality: how close splices are to the true motion."""
