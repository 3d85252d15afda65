"""Files that are whole or absent, folders that one run at a time writes, and what is remembered between runs."""
