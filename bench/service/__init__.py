"""What the service does under load, on one machine: `python -m bench.service [WHAT] [--check]`."""
