"""Aligning hands that were captured apart to bodies, and merging them. Imports `preparation` and below."""
