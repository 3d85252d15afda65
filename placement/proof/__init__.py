"""Bounds that no layout exceeds."""
