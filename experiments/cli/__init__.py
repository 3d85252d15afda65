"""The command `camring`: what it understands, and how it ends."""
