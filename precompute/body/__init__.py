"""What one body shows: joint paths, posture, foot contacts, its rig. Imported by every other room of `precompute`."""
