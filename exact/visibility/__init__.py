"""What one camera sees of every face, and how the views of many are counted: the method, file by file."""
