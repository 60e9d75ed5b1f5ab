"""Banks, the evaluator and characters."""
