"""Which face of a file each face of a mesh is, for lists of faces that people write down."""

import numpy as np
import trimesh

# Names under which a repaired mesh carries it.
NUMBER, COUNT = "file_face", "n_file_faces"


def file_faces(mesh: trimesh.Trimesh) -> tuple[np.ndarray, int]:
    """Number in the file of each face, and how many faces the file has; both from 0, as lists of faces count.

    Faces that `meshes.check` or `meshes.load` removed leave gaps. A repaired mesh carries the numbers in
    `face_attributes["file_face"]` and `metadata["n_file_faces"]`; any other mesh is its own file.

    Returns
    -------
    ((F,) ndarray of int, int)

    Examples
    --------
    >>> from meshes import check
    >>> twice = trimesh.Trimesh(np.eye(3), [[0, 1, 2], [1, 2, 0], [2, 1, 0]], process=False)
    >>> number, count = file_faces(check(twice, repair=True))
    >>> number.tolist(), count
    ([0, 2], 3)
    """
    number = mesh.face_attributes.get(NUMBER)
    if number is None or COUNT not in mesh.metadata:
        return np.arange(len(mesh.faces)), len(mesh.faces)
    return np.asarray(number, dtype=np.int64), int(mesh.metadata[COUNT])


def number_faces(mesh: trimesh.Trimesh, number: np.ndarray, count: int) -> None:
    """Let `mesh` know that its faces are those with the (F,) numbers `number` of the `count` faces of a file."""
    mesh.face_attributes[NUMBER] = number
    mesh.metadata[COUNT] = count
