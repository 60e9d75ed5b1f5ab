"""How the code is built: its rooms, their imports, and the layers that the contracts hold."""
