"""Benchmarks of standing actions: how close they come to the same action performed on a locomotion."""
