"""Soft coverage, which can be differentiated, and the descent along it."""
