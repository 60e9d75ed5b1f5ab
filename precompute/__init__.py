"""The offline job and the papers' whole-clip splice."""
