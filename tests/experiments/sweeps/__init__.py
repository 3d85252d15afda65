"""What takes long, task by task."""
