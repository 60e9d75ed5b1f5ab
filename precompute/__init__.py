"""The offline job and the papers' whole-clip splice.

Imports `runtime` and `motion`. Imported by commands and benchmarks.
"""
