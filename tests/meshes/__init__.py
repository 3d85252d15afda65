"""Loading, checking and mending meshes, and the reference sites."""
