"""Measures retargeting between the rigs of the field; `python -m bench.retarget`."""
