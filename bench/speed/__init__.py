"""Time and memory per character and frame, and of the offline job."""
