"""What a bank is on disk: manifest, tables and their checks. Imported by the rest of `runtime` and by `precompute`."""
