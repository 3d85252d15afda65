"""The surface of a report: cut where the set of cameras changes, so that every way to colour it is exact.

One geometry serves all: a colouring is one byte for each of its triangles.
"""

import base64
import gzip
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import exact
from exact.show import TOO_NEAR_COLOUR, UNCOUNTED_COLOUR, UNSEEN_COLOUR, colours, too_near

# From this number of views on, colours are not told apart any more.
MOST_SHADES = 8
# Coordinates are whole multiples of the greatest extent over this: 1 µm for a site 60 mm wide.
STEPS = 65535
# Room around what is seen, in parts of its greatest extent.
MARGIN = 0.06
# Rays that fall less than this, of what they go along the optical axis, do not meet the level of the surface.
SHALLOWEST = 1e-3
BOTH_COLOUR, GAINED_COLOUR, LOST_COLOUR = "#b9d3e6", "#1a7f5a", "#c65b1c"
SEEN_COLOUR, MISSED_COLOUR = "#4d9ac4", "#a9a39a"


@dataclass(frozen=True)
class Shade:
    """One colour of a colouring: what it stands for, and how much of the surface has it [mm²].

    No area is told of what no camera sees: most of it is the outside of the mesh, far from any field of view.
    """

    label: str
    colour: str
    area: float | None


@dataclass(frozen=True, eq=False)
class Colouring:
    """One way to look at the surface.

    Attributes
    ----------
    name : str
        For the button.
    caption : str
    shades : tuple of Shade
    shade : (N,) ndarray of uint8
        Index into `shades` for each triangle.
    cameras : (B,) ndarray of int
        Whose fields of view are shown with it.
    """

    name: str
    caption: str
    shades: tuple[Shade, ...]
    shade: np.ndarray
    cameras: np.ndarray


@dataclass(frozen=True, eq=False)
class DrawnSurface:
    """A surface with its colourings.

    Attributes
    ----------
    vertices : (V, 3) ndarray of uint16
        In steps of `step` from `origin`.
    triangles : (N, 3) ndarray of uint32
    origin : (3,) ndarray
        [mm]
    step : float
        [mm]
    frame : (3, 2) ndarray or None
        Box around all that some camera sees, with a margin [mm]; None if none sees anything.
    colourings : tuple of Colouring
        The layout compared, the proposed one, their difference, then each camera of the proposed one; without one to
        compare with, neither it nor a difference.
    proposed : int
        Which of the colourings is the proposed layout.
    camera_areas : (M,) ndarray
        What each camera of the proposed layout sees [mm²].
    fields : (C, 4, 3) ndarray
        Corners of the field of view of each camera, of the layout compared first, at the level of the highest point
        that is seen [mm].
    """

    vertices: np.ndarray
    triangles: np.ndarray
    origin: np.ndarray
    step: float
    frame: np.ndarray | None
    colourings: tuple[Colouring, ...]
    proposed: int
    camera_areas: np.ndarray
    fields: np.ndarray

    def content(self) -> dict:
        """What the page's program must know besides what is packed."""
        return {
            "n_vertices": len(self.vertices),
            "n_triangles": len(self.triangles),
            "origin": self.origin.tolist(),
            "step": self.step,
            "frame": None if self.frame is None else self.frame.tolist(),
            "proposed": self.proposed,
            "colourings": [
                {
                    "name": one.name,
                    "caption": one.caption,
                    "fields": np.round(self.fields[one.cameras], 3).tolist(),
                    "shades": [
                        {"words": s.label + ("" if s.area is None else f": {s.area:.2f} mm²"), "colour": s.colour}
                        for s in one.shades
                    ],
                }
                for one in self.colourings
            ],
        }

    def packed(self) -> str:
        """Triangles, vertices and the shades of every colouring, little-endian, gzip, base64."""
        shades = b"".join(colouring.shade.tobytes() for colouring in self.colourings)
        return packed(self.triangles.astype("<u4").tobytes() + self.vertices.astype("<u2").tobytes() + shades)


def packed(content: bytes) -> str:
    """Compressed, as text that can stand in a page; the same content always gives the same text.

    Examples
    --------
    >>> gzip.decompress(base64.b64decode(packed(b"abc")))
    b'abc'
    """
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")


@dataclass(frozen=True)
class ShownLayout:
    """One of the layouts to look at.

    Attributes
    ----------
    name : str
        For its button.
    words : str
        What sentences call it.
    cameras : tuple of exact.Camera
    """

    name: str
    words: str
    cameras: tuple[exact.Camera, ...]


def compared_surface(
    scene: exact.Scene,
    compared: ShownLayout | None,
    proposed: ShownLayout,
    places: Sequence[str],
    axis: np.ndarray,
    demand: exact.Demand,
    maximum: tuple[float, str] | None = None,
) -> DrawnSurface:
    """A layout on a mesh, beside another if there is one to compare with.

    Parameters
    ----------
    scene : exact.Scene
    compared, proposed : ShownLayout
    places : (M,) sequence of str
        Where each camera of the proposed one sits, in words.
    axis : (3,) ndarray
        Up, as the cameras have it.
    demand : exact.Demand
        What makes a point count.
    maximum : (float, str), optional
        Area of which fractions are told [mm²], and what it is called.

    Examples
    --------
    >>> import trimesh
    >>> plate, ring = trimesh.creation.box((10, 10, 2)), exact.Ring()
    >>> one, two = (tuple(ring.cameras(angles)) for angles in ([0.0, np.pi], [0.5, 2.0]))
    >>> even, found = ShownLayout("equidistant", "the equidistant one", one), ShownLayout("optimised", "this one", two)
    >>> places, up = ["at 29°", "at 115°"], ring.frame[:, 2]
    >>> made = compared_surface(exact.Scene(plate), even, found, places, up, exact.Demand())
    >>> [(colouring.name, len(colouring.shades)) for colouring in made.colourings]
    [('equidistant', 3), ('optimised', 3), ('difference', 3), ('camera 1', 2), ('camera 2', 2)]
    """
    before = () if compared is None else compared.cameras
    cameras, n, first = (*before, *proposed.cameras), len(proposed.cameras), len(before)
    of_compared = np.arange(len(cameras)) < first
    sets = exact.view_sets(scene, cameras, demand=demand)
    vertices, triangles, of, nowhere, origin, step = _geometry(scene, sets)
    areas = np.concatenate([sets.areas, nowhere])
    seen = np.concatenate([sets.seen, np.zeros((2, len(cameras)), dtype=bool)])

    def colouring(
        name: str, caption: str, kind: np.ndarray, table: list[tuple[str, str]], unseen: int, of_cameras: np.ndarray
    ) -> Colouring:
        """`kind` (S + 2,) is the row of `table` for each set, the last set what does not count.

        Of the row `unseen` no area is told.
        """
        kind = kind.copy()
        kind[-1] = len(table)
        area = np.bincount(kind, weights=areas, minlength=len(table) + 1)
        rows = [*table, ("not counted", UNCOUNTED_COLOUR)]
        used = np.unique(kind[of])
        shades = []
        for row in used.tolist():
            told = row not in (unseen, len(table))
            shades.append(Shade(rows[row][0], rows[row][1], float(area[row]) if told else None))
        shade = np.searchsorted(used, kind)[of].astype(np.uint8)
        return Colouring(name, caption, tuple(shades), shade, of_cameras)

    def met_by(chosen: np.ndarray) -> np.ndarray:
        return np.concatenate([sets.met(demand=demand, cameras=chosen), np.zeros(2, dtype=bool)])

    def views(name: str, chosen: np.ndarray) -> Colouring:
        threshold, met = demand.threshold, met_by(chosen)
        shades = max(threshold, min(n, MOST_SHADES))
        palette = colours(shades, threshold)
        table = [(views_words(count, shades, n, demand), hex_colour(palette[count])) for count in range(shades + 1)]
        count = np.minimum(seen[:, chosen].sum(axis=1), shades)
        table.append((too_near(demand), TOO_NEAR_COLOUR))
        kind = np.where((count >= threshold) & ~met, shades + 1, count)
        area = float(areas[met].sum())
        part = "" if maximum is None else f", {100 * area / maximum[0]:.2f} % of {maximum[1]}"
        return colouring(name, f"{name}: {area:.2f} mm² reconstructable{part}", kind, table, 0, np.flatnonzero(chosen))

    def difference(one: ShownLayout) -> Colouring:
        met_before, met = met_by(of_compared), met_by(~of_compared)
        gained, lost = float(areas[met & ~met_before].sum()), float(areas[met_before & ~met].sum())
        return colouring(
            "difference",
            f"{proposed.words.capitalize()} gains {gained:.2f} mm² and loses {lost:.2f} mm²: {gained - lost:+.2f} mm².",
            np.select([met_before & met, met, met_before], [0, 1, 2], 3),
            [
                ("reconstructable with both", BOTH_COLOUR), (f"with {proposed.words} only", GAINED_COLOUR),
                (f"with {one.words} only", LOST_COLOUR), ("with neither", UNSEEN_COLOUR),
            ],
            3,
            np.flatnonzero(~of_compared),
        )  # fmt: skip

    camera_areas = areas @ seen[:, first:]
    single = [
        colouring(
            f"camera {number}",
            f"Camera {number} {place} sees {camera_areas[number - 1]:.2f} mm².",
            np.where(seen[:, first + number - 1], 1, 0),
            [("not seen by this camera", MISSED_COLOUR), ("seen by this camera", SEEN_COLOUR)],
            0,
            np.array([first + number - 1]),
        )
        for number, place in enumerate(places, start=1)
    ]
    layouts = [views(proposed.name, ~of_compared)]
    if compared is not None:
        layouts = [views(compared.name, of_compared), *layouts, difference(compared)]
    shown = vertices[triangles[np.asarray(seen.any(axis=1))[of]].reshape(-1)]
    frame = None
    if len(shown):
        box = origin[:, None] + step * np.stack([shown.min(axis=0), shown.max(axis=0)], axis=1)
        frame = box + MARGIN * np.ptp(box, axis=1).max() * np.array([-1.0, 1.0])
    highest = (shown * step + origin) @ axis if len(shown) else np.zeros(1)
    return DrawnSurface(
        vertices, triangles, origin, step, frame, (*layouts, *single), int(compared is not None), camera_areas,
        _fields(cameras, axis, float(highest.max())),
    )  # fmt: skip


def drawn_surface(
    scene: exact.Scene,
    ring: exact.Ring,
    angles: np.ndarray,
    demand: exact.Demand,
    ring_area: float | None = None,
    rolls: np.ndarray | None = None,
) -> DrawnSurface:
    """A layout of one ring on a mesh beside the equidistant one.

    Parameters
    ----------
    scene : exact.Scene
    ring : exact.Ring
    angles : (M,) ndarray
        Ring angles [rad].
    demand : exact.Demand
        What makes a point count.
    ring_area : float, optional
        Ring maximum, to tell fractions of it [mm²].
    rolls : (M,) ndarray, optional
        Of the cameras [rad], as `exact.Ring.cameras` takes them.

    Examples
    --------
    >>> import trimesh
    >>> plate = trimesh.creation.box((10, 10, 2))
    >>> made = drawn_surface(exact.Scene(plate), exact.Ring(), np.array([0.0, np.pi]), exact.Demand())
    >>> made.colourings[3].caption
    'Camera 1 at 0.0° sees 120.00 mm².'
    """
    even = ShownLayout("equidistant", "the equidistant one", tuple(ring.cameras(ring.equidistant(len(angles)))))
    found = ShownLayout("optimised", "the optimised layout", tuple(ring.cameras(angles, rolls)))
    places = [f"at {np.degrees(angle):.1f}°" for angle in angles]
    maximum = (ring_area, "the ring maximum") if ring_area else None
    return compared_surface(scene, even, found, places, ring.frame[:, 2], demand, maximum)


def _fields(cameras: Sequence[exact.Camera], axis: np.ndarray, level: float) -> np.ndarray:
    """(M, 4, 3) corners of the fields of view of cameras on the plane of the points X with axis · X = level [mm]."""
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    found = []
    for camera in cameras:
        rays = np.column_stack([signs * camera.half_extent, np.ones(4)]) @ camera.rotation
        down = np.minimum(rays @ axis, -SHALLOWEST)
        found.append(camera.position + rays * ((level - camera.position @ axis) / down)[:, None])
    return np.array(found)


def _geometry(scene: exact.Scene, sets: exact.ViewSets):
    """Vertices in steps, triangles, the set of each, areas of what is in none [mm²], origin and step [mm].

    After the sets come the empty one and what does not count.
    """
    mesh, exclude, parts = scene.everything, ~scene.counted, sets.to_mesh()
    left_out = np.asarray(mesh.faces)[exclude] + len(parts.vertices)
    points = np.concatenate([parts.vertices, mesh.vertices])
    triangles = np.concatenate([parts.faces, left_out])
    own = np.asarray(parts.face_attributes["set"])
    empty = len(sets.seen)
    of = np.concatenate([np.where(own < 0, empty, own), np.full(len(left_out), empty + 1)])
    nowhere = np.array([parts.area_faces[own < 0].sum(), mesh.area_faces[exclude].sum()])
    origin = mesh.bounds[0]
    step = float(np.ptp(mesh.bounds, axis=0).max()) / STEPS
    vertices, index = np.unique(np.round((points - origin) / step), axis=0, return_inverse=True)
    triangles = index.reshape(-1)[triangles]
    flat = (triangles == np.roll(triangles, 1, axis=1)).any(axis=1)  # slivers narrower than a step
    triangles, of = triangles[~flat], of[~flat]
    used, index = np.unique(triangles, return_inverse=True)
    return vertices[used].astype(np.uint16), index.reshape(-1, 3).astype(np.uint32), of, nowhere, origin, step


def views_words(count: int, shades: int, n_cameras: int, demand: exact.Demand) -> str:
    """What a colour stands for: that many views, of which from `shades` on are not told apart."""
    more = " or more" if count == shades < n_cameras else ""
    cameras = f"{count or 'no'}{more} camera{'' if count == 1 and not more else 's'}" if count else "no camera"
    return f"seen by {cameras}{' (too few)' if 0 < count < demand.threshold else ''}"


def hex_colour(colour: np.ndarray) -> str:
    """As a page takes it: red, green and blue, (3,) from 0 to 1.

    Examples
    --------
    >>> hex_colour(np.array([1.0, 0.5, 0.0]))
    '#ff8000'
    """
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour.tolist())
