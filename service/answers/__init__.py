"""Poses, splices and streams over HTTP."""
