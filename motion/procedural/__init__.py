"""The built-in motions and hand gestures, generated with known truth for tests, benchmarks and the demo."""
