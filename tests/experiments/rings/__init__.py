"""The same request on many rings."""
