"""The simulated reconstruction: rendered images of a layout's cameras are matched, and compared with the surface."""
