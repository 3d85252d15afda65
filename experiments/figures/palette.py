"""Colours of curves: what was optimised, what it is compared with, and what bounds it."""

BLUE, GREEN, GREY, ORANGE = "#1f5fa8", "#2a8c5a", "0.45", "#c65b1c"
