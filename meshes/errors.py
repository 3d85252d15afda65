"""The exception and the warning of `meshes`."""

# How a message of the library says that a repair would help, and how the command line says the same.
REPAIR_CALL, REPAIR_OPTION = "`meshes.load(path, repair=True)`", "--repair"
TWO_SIDED_CALL, TWO_SIDED_OPTION = "`two_sided=True`", "--two-sided"


class MeshError(ValueError):
    """A file or a mesh that cannot be used: says what was got, what is needed, what to do next."""

    @property
    def at_command_line(self) -> str:
        """The same message with options for calls.

        Examples
        --------
        >>> MeshError("mixed winding; `meshes.load(path, repair=True)` winds all alike").at_command_line
        'mixed winding; --repair winds all alike'
        """
        return str(self).replace(REPAIR_CALL, REPAIR_OPTION).replace(TWO_SIDED_CALL, TWO_SIDED_OPTION)


class MeshWarning(UserWarning):
    """A mesh that can be used but looks wrong: says what was seen, what it may mean, what to do next."""
