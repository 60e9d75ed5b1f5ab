"""The bank on disk: manifest, tables and their checks. Used by the rest of `runtime` and by `precompute`."""
