"""Poses, splices and streams over HTTP. Imported by `routes`."""
