"""Alignment of separately captured hands to bodies, and merging. Imports `preparation` and the rooms below it."""
