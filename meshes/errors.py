"""The exception and the warning of `meshes`."""


class MeshError(ValueError):
    """A file or a mesh that cannot be used: says what was got, what is needed, what to do next."""


class MeshWarning(UserWarning):
    """A mesh that can be used but looks wrong: says what was seen, what it may mean, what to do next."""
