"""Motion files: bytes in, clips out, and back. Imported by whoever reads or writes files."""
