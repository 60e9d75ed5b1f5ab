"""How the code is built: its packages, their imports, and the layers that the contracts allow."""
