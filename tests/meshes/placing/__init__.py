"""A place for a ring over meshes that lie anywhere."""
