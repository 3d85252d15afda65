"""Surrogate, layouts, search, proof and what is made of them."""
