"""How near splices come to the truth."""
