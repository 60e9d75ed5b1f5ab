"""How requests are read and frames are written: query, axes, encodings. Imported by `answers` and `characters`."""
