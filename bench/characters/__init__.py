"""Benchmarks of characters over time: pops, steps, replays and cost."""
