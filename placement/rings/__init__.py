"""Cameras on several rings: which of them sits on which, and where."""
