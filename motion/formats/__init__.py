"""Motion file formats: reads files into clips and writes clips as files. Imported by all that reads or writes files."""
