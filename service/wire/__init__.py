"""Parses queries and encodes frames: axes, number formats, messages."""
