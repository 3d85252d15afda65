"""Sample points of a surface, from where on the ring each is seen, and what layouts reconstruct of them."""
