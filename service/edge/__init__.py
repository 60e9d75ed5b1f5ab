"""Limits and protocols at the socket, before any route. Imported by `server` and `front`."""
