"""How well hands are aligned to bodies."""
