"""Load and check a mesh; build the reference sites."""
