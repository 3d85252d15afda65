"""What is seen of a surface from where, and from where most is."""
