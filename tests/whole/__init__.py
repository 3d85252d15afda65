"""What holds for all packages together: imports, names, documentation, dependencies."""
