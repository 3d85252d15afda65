"""How commands and scripts end, whatever happens to them."""
