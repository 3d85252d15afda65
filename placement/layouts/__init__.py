"""Which layouts there may be: constraints, what they leave of the ring, and maps that keep to them."""
