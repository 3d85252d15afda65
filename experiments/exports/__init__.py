"""Layouts in the formats of other programs: one file per format, and the register of them in `formats`."""
