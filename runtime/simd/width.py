"""The width of lanes, in a module without Numba, so that reading a bank does not import a compiler."""

LANES = 8  # float32 per vector
