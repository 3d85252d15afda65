"""Exact areas: closed forms, laws, rays, unions, published figures, and what is refused."""
