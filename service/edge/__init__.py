"""Limits and protocols at the socket, before any route."""
