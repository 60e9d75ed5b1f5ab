"""Benchmarks of speed and memory: per character and frame, of banks, and of the offline job."""
