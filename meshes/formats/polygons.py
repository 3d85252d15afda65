"""What every format comes to: vertices, and faces of any number of corners."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from meshes.errors import MeshError
from meshes.formats.text import shown


@dataclass(frozen=True, eq=False)
class Polygons:
    """The faces of a file, as the file gives them.

    Attributes
    ----------
    vertices : (V, 3) float
        In the file's unit.
    corners : (N,) int
        Vertices of the first face, then of the next.
    sizes : (F,) int
        How many corners each face has, at least 3.
    notes : tuple of str
        What was odd about the file, though it could be read.
    number : (F,) int or None
        Number in the file of each face, from 0; None for 0 to F - 1.
    n_in_file : int or None
        How many faces the file has; None for F.
    first : int
        What the file calls the first vertex.
    """

    vertices: np.ndarray
    corners: np.ndarray
    sizes: np.ndarray
    notes: tuple[str, ...] = ()
    number: np.ndarray | None = None
    n_in_file: int | None = None
    first: int = 0

    @staticmethod
    def of_triangles(vertices: np.ndarray, triangles: np.ndarray, notes: Sequence[str] = ()) -> "Polygons":
        """Triangles (F, 3) of vertices (V, 3)."""
        return Polygons(vertices, triangles.reshape(-1), np.full(len(triangles), 3), tuple(notes))

    @property
    def starts(self) -> np.ndarray:
        """(F,) place in `corners` of the first corner of each face."""
        return np.concatenate([[0], np.cumsum(self.sizes)[:-1]]).astype(np.int64)

    def of_open_end(self, name: str, last: bytes, corner_is_last: bool) -> "Polygons":
        """The same, with a note: a text whose last line has no end may be cut in it, and is refused if it looks so.

        Parameters
        ----------
        name : str
            Of the file, for messages.
        last : bytes
            The last line, which is that of the last face.
        corner_is_last : bool
            Whether it ends with a corner; what is cut off from something else does no harm.

        Raises
        ------
        MeshError
        """
        own = self.corners[len(self.corners) - self.sizes[-1] :]
        corner_is_last = corner_is_last and len(own) > 1
        # Of the number of a vertex one digit more would have made another, and both its edges are no one else's.
        may_be_longer = corner_is_last and 10 * (own[-1] + self.first) < len(self.vertices) + self.first
        if len(np.unique(own)) < min(3, len(own)) or (may_be_longer and not self._has_neighbour(own)):
            raise MeshError(
                f"{name}: the last line, {shown(last)}, has no end and makes a face that fits no other. The file is "
                "cut short; copy or export it again, or put an end to the line if it is whole"
            )
        return replace(self, notes=(*self.notes, "its last line has no end; check that the file is whole"))

    def _has_neighbour(self, last: np.ndarray) -> bool:
        """Whether another face runs along an edge at the last corner of the last face, the other way."""
        before = self.corners[: len(self.corners) - len(last)]
        sizes = self.sizes[:-1][self.sizes[:-1] > 0]
        ends = np.cumsum(sizes) - 1
        after = np.roll(before, -1)
        after[ends] = before[ends - sizes + 1]
        edges = ((last[-1], last[-2]), (last[0], last[-1]))
        return any(bool(((before == one) & (after == two)).any()) for one, two in edges)

    def checked(self, name: str) -> "Polygons":
        """Without what has fewer than three corners and is no face; the other faces keep their numbers.

        Raises
        ------
        MeshError
            If a face has a corner that is no vertex.
        """
        if len(self.sizes) == 0:
            return self
        wrong = (self.corners < 0) | (self.corners >= len(self.vertices))
        if wrong.any():
            starts = self.starts
            face = int(np.searchsorted(starts, np.flatnonzero(wrong)[0], side="right") - 1)
            corners = ", ".join(str(one) for one in self.corners[starts[face] : starts[face] + self.sizes[face]][:6])
            raise MeshError(
                f"{name}: face {face} refers to vertices {corners}, but there are vertices 0 to "
                f"{len(self.vertices) - 1} only. The file is damaged; export it again"
            )
        small = self.sizes < 3
        if not small.any():
            return self
        count = int(small.sum())
        left_out = f"left out {count} face{'s' if count > 1 else ''} of fewer than three corners"
        return replace(
            self,
            corners=self.corners[np.repeat(~small, self.sizes)],
            sizes=self.sizes[~small],
            notes=(*self.notes, left_out),
            number=np.flatnonzero(~small),
            n_in_file=len(small),
        )
