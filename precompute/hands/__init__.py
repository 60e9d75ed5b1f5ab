"""Alignment of separately captured hands to bodies, and merging."""
