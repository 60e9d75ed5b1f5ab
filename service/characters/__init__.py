"""Characters over a WebSocket."""
