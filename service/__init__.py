"""Serves frames over HTTP and WebSocket. The offline job runs in its own process."""
