"""Benchmarks of the service under load, on one machine: `python -m bench.service [WHAT ...] [--check]`."""
