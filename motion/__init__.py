"""Skeletons, clips, roles, file formats and the built-in motions.

Imports nothing else of the project; everything may import it.
"""
