"""Cameras on several rings, against exhaustive search and cameras built by hand."""
