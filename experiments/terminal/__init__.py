"""What appears on the terminal: notes, tables, progress."""
