"""How wide the lanes are; apart from what compiles, so that reading a bank needs no compiler."""

LANES = 8  # float32 that are computed with at once
