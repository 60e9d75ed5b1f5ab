"""The built-in motions and hand gestures, generated with a known truth, for tests, benchmarks and the demo."""
