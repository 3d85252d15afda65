"""Predicted errors: against triangulations and closed forms, and what is shared to find them quickly."""
