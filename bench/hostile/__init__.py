"""Damaged motion files, and what reading them leads to."""
