"""Measurements of one body: joint paths, posture, foot contacts, rig. All other rooms of `precompute` import it."""
