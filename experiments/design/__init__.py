"""A page on which a person moves the cameras of a ring, and a server that says at once what they reconstruct."""
