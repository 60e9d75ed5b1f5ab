"""The offline job, and the papers' whole-clip splice.

Imports `runtime` and `motion`; commands and benchmarks import it.
"""
