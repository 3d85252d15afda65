"""Tell two meshes apart by their content."""

import hashlib

import numpy as np
import trimesh


def fingerprint(mesh: trimesh.Trimesh) -> str:
    """SHA-256 of the corners (float64) of all faces in their order, in hexadecimal.

    The numbering of the vertices does not enter: a mesh whose coordinates are exact in single precision, such as
    every reference site, keeps its fingerprint through an STL file.

    Examples
    --------
    >>> box = trimesh.creation.box()
    >>> fingerprint(box) == fingerprint(box.copy()), fingerprint(box) == fingerprint(trimesh.creation.box((1, 1, 2)))
    (True, False)
    """
    corners = np.asarray(mesh.vertices, dtype="<f8")[np.asarray(mesh.faces)]
    return hashlib.sha256((corners + 0.0).tobytes()).hexdigest()  # + 0.0 turns -0.0 into 0.0
