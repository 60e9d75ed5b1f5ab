"""Skeletons, clips, roles, file formats and the built-in motions."""
