"""The exact derivative of the exact area."""
