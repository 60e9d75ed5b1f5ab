"""Characters over a WebSocket. Imported by `front`."""
