"""Preparation of a clip for a bank: alignment, loop, measurements."""
