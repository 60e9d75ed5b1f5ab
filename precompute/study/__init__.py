"""The correlation of upper body and legs (Heck's thesis, 4.1)."""
