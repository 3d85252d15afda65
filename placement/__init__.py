"""Where the cameras of a ring should sit."""
