"""Measurements of one body: joint paths, posture, foot contacts, rig."""
