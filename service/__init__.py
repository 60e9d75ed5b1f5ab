"""Frames over HTTP and WebSocket.

Imports `runtime` and `motion`; never `precompute`, which it runs in processes of its own.
"""
