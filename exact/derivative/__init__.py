"""How the exact area changes when a camera moves: its own derivative, without steps and without samples."""
