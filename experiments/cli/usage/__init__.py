"""How each subcommand is called: its options and what its help says, one file a subcommand. Nothing heavy here."""
