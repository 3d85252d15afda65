"""How right and how fast camring is on this machine."""
