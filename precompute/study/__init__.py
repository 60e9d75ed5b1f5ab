"""Which motions of the upper body go with the legs (Heck's thesis, 4.1). No other room imports it."""
