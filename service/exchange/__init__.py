"""New clips and new banks while the service runs."""
