"""Tables that commands print and write."""
