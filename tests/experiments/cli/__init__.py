"""Subcommands: what they print, write and refuse."""
