"""Pictures of a layout: what it covers, what its cameras see; how many are needed; the built-in sites."""
