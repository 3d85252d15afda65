"""The simulated reconstruction: rendered images of a layout's cameras are matched, and compared with the surface."""

# What it leaves in its folder, beside a folder for each layout.
TABLE, PREDICTION, ERRORS, FIGURES = OUTPUTS = ("simulation.csv", "prediction.png", "errors.png", "simulation.json")
