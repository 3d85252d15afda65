"""One page about a layout, with the surface in 3-D."""

NAME = "report.html"
