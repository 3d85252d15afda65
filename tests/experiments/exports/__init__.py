"""Layouts and areas for other programs, read back with their readers."""
