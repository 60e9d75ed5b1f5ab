"""New clips and new banks while the service runs. Imported by `app` and `front`."""
