"""Banks, the evaluator and characters. Imports `motion` only; `precompute`, `service` and above may import it."""
