"""Frames of a character over UDP, in the protocols of receivers that exist: VMC and JSON Live Link."""
