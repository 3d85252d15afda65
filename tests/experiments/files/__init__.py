"""Files that a run leaves for the next."""
