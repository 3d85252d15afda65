"""What the header of a PLY file announces."""

import re
from dataclasses import dataclass

import numpy as np

from meshes.errors import MeshError
from meshes.formats.text import shown

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8", "long": "i8", "ulong": "u8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
# The header is text and short; what has no end up to here is none.
LONGEST = 1_000_000


@dataclass(frozen=True)
class Property:
    """A number of each element, or a list of numbers: then `count` is the type of their number."""

    name: str
    kind: np.dtype
    count: np.dtype | None = None


@dataclass(frozen=True)
class Element:
    """So many vertices, faces or the like, each with these properties."""

    name: str
    number: int
    properties: tuple[Property, ...]

    @property
    def least_words(self) -> int:
        """How many numbers each has at least: lists may be empty."""
        return len(self.properties)

    @property
    def least_bytes(self) -> int:
        """How long each is at least in a binary file."""
        return sum((one.kind if one.count is None else one.count).itemsize for one in self.properties)


@dataclass(frozen=True)
class Header:
    """The elements of a file, in its order; whether it is text; where its body begins."""

    ascii: bool
    elements: tuple[Element, ...]
    length: int

    def number(self, name: str) -> int:
        """How many elements of a name there are."""
        return sum(one.number for one in self.elements if one.name == name)


def read_header(name: str, data: bytes) -> Header:
    """The header of a PLY file; upper case, blank lines and any comments are allowed.

    Raises
    ------
    MeshError
    """
    # With line ends of the old Mac and of Windows, the body begins after as many bytes as the first line's end has.
    start = re.match(rb"ply[ \t]*(\r\n|\n|\r)", data, re.I)
    newline = start[1] if start else b"\n"
    end = re.compile(rb"^[ \t]*end_header[ \t]*(?:" + newline + rb"|\n|\Z)", re.M | re.I)
    body = end.search(data[:LONGEST] if newline != b"\r" else data[:LONGEST].replace(b"\r", b"\n"))
    if not (start and body):
        raise MeshError(f'{name}: no PLY header ("ply" ... "end_header"); the file is damaged or of another kind')
    order, elements, properties = None, [], []
    for line in re.split(rb"\r\n|\n|\r", data[start.end() : body.start()]):
        words = line.decode("ascii", errors="replace").split()
        keyword = words[0].lower() if words else "comment"
        try:
            if keyword == "format":
                order = ORDERS[words[1].lower()]
            elif keyword == "element":
                properties = []
                elements.append((words[1].lower(), int(words[2]), properties))
            elif keyword == "property":
                properties.append(_property([word.lower() for word in words[1:]], order or ""))
            elif keyword not in ("comment", "obj_info"):
                raise ValueError
        except (KeyError, IndexError, ValueError) as error:
            raise MeshError(
                f"{name}: its header says {shown(line)}, which is nothing that a PLY file says. It is damaged; "
                "export it again"
            ) from error
    if order is None:
        raise MeshError(f'{name}: no "format" in its header, which says whether it is text. Export the file again')
    found = tuple(Element(kind, number, tuple(kept)) for kind, number, kept in elements)
    header = Header(order == "", found, body.end())
    _refuse_more_than_fits(name, header, len(data) - body.end())
    return header


def _property(words: list[str], order: str) -> Property:
    if words[0] != "list":
        kind, name = words
        return Property(name, np.dtype(order + TYPES[kind]))
    _, count, kind, name = words
    return Property(name, np.dtype(order + TYPES[kind]), np.dtype(order + TYPES[count]))


def _refuse_more_than_fits(name: str, header: Header, n_bytes: int) -> None:
    """Before any memory is taken for it. In text, each number takes two bytes but for the last."""
    n_vertices, n_faces = header.number("vertex"), header.number("face")
    least = (
        sum(one.number * (2 * one.least_words if header.ascii else one.least_bytes) for one in header.elements)
        - header.ascii
    )
    if any(one.number < 0 for one in header.elements) or least > n_bytes:
        raise MeshError(
            f"{name}: the header announces {n_vertices} vertices and {n_faces} faces, but only {n_bytes} bytes "
            "follow. The file is cut short or damaged; copy or export it again"
        )
