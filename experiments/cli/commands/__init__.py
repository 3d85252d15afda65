"""What each subcommand does, one file a subcommand."""
