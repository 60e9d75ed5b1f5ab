"""Serves frames over HTTP and WebSocket.

Imports `runtime` and `motion`, never `precompute`: the offline job runs in its own process.
"""
