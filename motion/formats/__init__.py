"""Motion file formats: reads files into clips and writes clips as files."""
