"""Read the faces of PLY files: text and binary in both byte orders, polygons of any sizes, triangle strips."""

import numpy as np

from meshes.errors import MeshError
from meshes.formats.ply_header import Element, Header, read_header
from meshes.formats.polygons import Polygons
from meshes.formats.text import numbers, plain

# What the corners of a face are called.
CORNERS = ("vertex_indices", "vertex_index")
# One column for each property of an element: numbers, or for lists their sizes and all their numbers.
Columns = dict[str, np.ndarray | tuple[np.ndarray, np.ndarray]]


def read_ply(name: str, data: bytes) -> Polygons:
    """Faces of a PLY file.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    data : bytes
        The whole file.

    Raises
    ------
    MeshError
        If it is cut short or holds no surface.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") or data.startswith(b"\xef\xbb\xbf"):
        data = plain(data)
    header = read_header(name, data)
    words, place, elements = [], header.length, {}
    if header.ascii:
        words, place = plain(data[header.length :]).split(), 0
    for element in header.elements:
        try:
            columns, place = _from_words(element, words, place) if header.ascii else _from_bytes(element, data, place)
        except (ValueError, OverflowError) as error:
            raise MeshError(
                f"{name}: not a readable PLY file: among its {element.name} elements stands {error}. Export it again"
            ) from error
        if columns is None:
            raise _cut_short(name, header, element)
        elements.setdefault(element.name, columns)
    notes = _left_over(name, header, words[place:] if header.ascii else data[place:])
    found = _polygons(name, header, elements, notes)
    if not header.ascii or data[-1:].isspace():
        return found
    last = header.elements[-1]
    corner_is_last = last.name == "face" and last.properties[-1].name in CORNERS
    return found.of_open_end(name, b" ".join(words[-8:]), corner_is_last)


def _cut_short(name: str, header: Header, element: Element) -> MeshError:
    return MeshError(
        f"{name}: the header announces {header.number('vertex')} vertices and {header.number('face')} faces, but the "
        f"file ends among its {element.name} elements. It is cut short or damaged; copy or export it again"
    )


def _left_over(name: str, header: Header, rest: bytes | list[bytes]) -> list[str]:
    """What is odd about what follows the last element."""
    if isinstance(rest, list):
        if rest:
            raise MeshError(
                f"{name}: {len(rest)} words follow the last element that its header announces. The header or a line "
                "is wrong; export the file again"
            )
        return []
    if not rest.strip(b"\0\r\n\t \x1a"):
        return []
    row = max((one.least_bytes for one in header.elements), default=1)
    if len(rest) > row:
        raise MeshError(
            f"{name}: {len(rest)} bytes follow the last element that its header announces. The header or the file is "
            "wrong; export it again"
        )
    return [f"ignored {len(rest)} bytes at its end"]


def _from_words(element: Element, words: list[bytes], place: int) -> tuple[Columns | None, int]:
    """Columns of an element from the words of a text, and where the next one begins; None if the text ends before."""
    properties = element.properties
    if all(one.count is None for one in properties):
        end = place + element.number * len(properties)
        if end > len(words):
            return None, place
        table = np.array(numbers(words[place:end])).reshape(element.number, len(properties))
        return {one.name: table[:, i] for i, one in enumerate(properties)}, end
    # The places of all numbers, one row after the other, since only the row says how long it is.
    scalars: dict[str, list[bytes]] = {one.name: [] for one in properties if one.count is None}
    lists: dict[str, tuple[list[int], list[bytes]]] = {one.name: ([], []) for one in properties if one.count}
    for _ in range(element.number):
        for one in properties:
            if place >= len(words):
                return None, place
            if one.count is None:
                scalars[one.name].append(words[place])
                place += 1
                continue
            size = int(words[place])
            if size < 0:
                raise ValueError(f"a list of {size} numbers")
            sizes, values = lists[one.name]
            sizes.append(size)
            values += words[place + 1 : place + 1 + size]
            place += 1 + size
    if place > len(words):
        return None, place
    columns: Columns = {name: np.array(numbers(kept)) for name, kept in scalars.items()}
    columns |= {
        name: (np.array(sizes, dtype=np.int64), np.array(numbers(kept))) for name, (sizes, kept) in lists.items()
    }
    return columns, place


def _from_bytes(element: Element, data: bytes, place: int) -> tuple[Columns | None, int]:
    """The same from the bytes of a binary file."""
    if element.number == 0:
        return {one.name: np.zeros(0) if one.count is None else _no_lists() for one in element.properties}, place
    # Most often all lists of a column are as long as the first: then the rows are alike.
    sizes = _sizes_of_row(element, data, place)
    if sizes is not None:
        row = _row(element, sizes)
        if place + row.itemsize * element.number <= len(data):
            table = np.frombuffer(data, row, element.number, place)
            if all((table[f"{i}n"] == size).all() for i, size in enumerate(sizes) if element.properties[i].count):
                return _columns(element, [table], np.arange(element.number)), place + row.itemsize * element.number
    return _from_odd_rows(element, data, place)


def _no_lists() -> tuple[np.ndarray, np.ndarray]:
    return np.zeros(0, dtype=np.int64), np.zeros(0)


def _sizes_of_row(element: Element, data: bytes, place: int) -> list[int] | None:
    """How long each list of the row at `place` is, 0 for what is no list; None if the file ends before."""
    sizes = []
    for one in element.properties:
        size = 0
        if one.count is not None:
            if place + one.count.itemsize > len(data):
                return None
            size = int(np.frombuffer(data, one.count, 1, place)[0])
            if size < 0:
                raise ValueError(f"a list of {size} numbers")
            place += one.count.itemsize
        place += one.kind.itemsize * (1 if one.count is None else size)
        sizes.append(size)
    return sizes if place <= len(data) else None


def _row(element: Element, sizes: list[int]) -> np.dtype:
    fields = []
    for i, (one, size) in enumerate(zip(element.properties, sizes, strict=True)):
        fields += [(f"{i}", one.kind)] if one.count is None else [(f"{i}n", one.count), (f"{i}", one.kind, (size,))]
    return np.dtype(fields)


def _from_odd_rows(element: Element, data: bytes, place: int) -> tuple[Columns | None, int]:
    """Rows of different lengths: first where each begins, then all of one shape at once."""
    shapes: dict[tuple[int, ...], list[int]] = {}
    of_row: dict[tuple[int, ...], list[int]] = {}
    steps = [(one.count, one.kind.itemsize) for one in element.properties]
    for number in range(element.number):
        start, sizes = place, []
        for count, width in steps:
            if count is None:
                place += width
                continue
            counted = data[place : place + count.itemsize]
            if len(counted) < count.itemsize:
                return None, place
            order = "big" if count.byteorder == ">" else "little"
            size = int.from_bytes(counted, order, signed=count.kind == "i")
            if count.kind == "f":
                size = int(np.frombuffer(counted, count)[0])
            if size < 0:
                raise ValueError(f"a list of {size} numbers")
            sizes.append(size)
            place += count.itemsize + size * width
        if place > len(data):
            return None, place
        shapes.setdefault(tuple(sizes), []).append(start)
        of_row.setdefault(tuple(sizes), []).append(number)
    view, tables = np.frombuffer(data, np.uint8), []
    for shape, starts in shapes.items():
        own = iter(shape)
        row = _row(element, [0 if one.count is None else next(own) for one in element.properties])
        picked = view[np.array(starts)[:, None] + np.arange(row.itemsize)]
        tables.append(np.ascontiguousarray(picked).view(row)[:, 0])
    order = np.concatenate([np.array(rows) for rows in of_row.values()])
    return _columns(element, tables, order), place


def _columns(element: Element, tables: list[np.ndarray], number: np.ndarray) -> Columns:
    """Columns of rows in several tables, each of rows of one shape; `number` is where each of their rows belongs."""
    columns: Columns = {}
    back = np.argsort(number, kind="stable")
    for i, one in enumerate(element.properties):
        if one.count is None:
            columns[one.name] = np.concatenate([table[f"{i}"] for table in tables]).astype(np.float64)[back]
            continue
        if len(tables) == 1:
            values = tables[0][f"{i}"]
            columns[one.name] = np.full(len(values), values.shape[1]), values.reshape(-1)
            continue
        sizes = np.concatenate([np.full(len(table), table[f"{i}"].shape[1]) for table in tables])
        values = np.concatenate([table[f"{i}"].reshape(-1) for table in tables])
        starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])[back]
        sizes = sizes[back]
        ends = np.cumsum(sizes)
        take = np.repeat(starts - (ends - sizes), sizes) + np.arange(ends[-1])
        columns[one.name] = sizes, values[take]
    return columns


def _polygons(name: str, header: Header, elements: dict[str, Columns], notes: list[str]) -> Polygons:
    vertex = elements.get("vertex", {})
    axes = [vertex.get(axis) for axis in "xyz"]
    if any(not isinstance(axis, np.ndarray) for axis in axes):
        raise MeshError(f"{name}: its vertices have no x, y and z; needed are three coordinates. Export it again")
    vertices = np.column_stack([np.asarray(axis, dtype=np.float64) for axis in axes])
    for kind in ("face", "tristrips"):
        found = _lists(elements.get(kind, {}))
        if found is None or len(found[0]) == 0:
            continue
        with np.errstate(invalid="ignore"):
            values = found[1]
            corners = np.where(np.isfinite(values.astype(np.float64)), values, -2).astype(np.int64)
        if (corners != values).any():
            raise MeshError(f"{name}: a face has corners that are no whole numbers. It is damaged; export it again")
        if kind == "tristrips":
            triangles = _of_strips(found[0], corners)
            return Polygons.of_triangles(vertices, triangles, [*notes, f"{len(triangles)} triangles in strips"])
        return Polygons(vertices, corners, found[0], tuple(notes))
    raise MeshError(f"{name}: {_without_faces(header, len(vertices))}")


def _lists(columns: Columns) -> tuple[np.ndarray, np.ndarray] | None:
    """The corners of faces: the list that is called so, or the only one."""
    lists = {name: column for name, column in columns.items() if isinstance(column, tuple)}
    named = [lists[name] for name in CORNERS if name in lists]
    return named[0] if named else next(iter(lists.values())) if len(lists) == 1 else None


def _of_strips(sizes: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(F, 3) triangles of strips: each corner makes one with the two before it, and -1 begins another strip.

    Every second triangle of a strip is wound the other way in it. Those with a corner twice only lead to the next.
    """
    strip = np.repeat(np.arange(len(sizes)), sizes)
    strip = strip * (len(corners) + 1) + np.cumsum(corners == -1)
    first = np.flatnonzero(np.diff(strip, prepend=-1))
    place = np.arange(len(corners)) - np.repeat(first, np.diff(first, append=len(corners)))
    # A -1 stands at the head of its strip and is no corner of it.
    place -= (corners[first] == -1)[np.searchsorted(first, np.arange(len(corners)), side="right") - 1]
    last = np.flatnonzero(place >= 2)
    triangles = np.stack([corners[last - 2], corners[last - 1], corners[last]], axis=1)
    turned = place[last] % 2 == 1
    triangles[turned] = triangles[turned][:, [1, 0, 2]]
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


def _without_faces(header: Header, n_vertices: int) -> str:
    needed = "needed is at least one triangle"
    names = {one.name for one in header.elements if one.number}
    if "range_grid" in names:
        return f"a range map, {n_vertices} vertices in a grid and no faces; {needed}. Make a surface of it first"
    if "edge" in names:
        return f"{n_vertices} vertices with edges but no faces, a wireframe; {needed}"
    cloud = ", a point cloud" if n_vertices else ""
    return f"{n_vertices} vertices and no faces{cloud}; {needed}. Make a surface of it first"
