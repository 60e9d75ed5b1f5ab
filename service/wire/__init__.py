"""Parses queries and encodes frames: axes, number formats, messages. Imported by `answers` and `characters`."""
