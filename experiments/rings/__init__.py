"""Which ring: the same request on many rings, one layout each."""
