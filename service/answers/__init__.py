"""Poses, splices and streams over HTTP. Imported by `front` and `openapi`."""
