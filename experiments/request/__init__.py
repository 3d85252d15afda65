"""What a person asks for: meshes, rig file, layout file, and the text of options."""
