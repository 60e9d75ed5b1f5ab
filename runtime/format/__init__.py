"""The bank on disk: manifest, tables and their checks."""
