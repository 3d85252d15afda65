"""The simulated reconstruction: images against projection, accuracy against prediction, and the command."""
