"""Rig files and the register of options."""
