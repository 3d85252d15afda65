"""Which views can be used, and how accurately a point that several cameras see is reconstructed from them."""
