"""The one exception class of `meshes`."""


class MeshError(ValueError):
    """A file or a mesh that cannot be used: says what was got, what is needed, what to do next."""
