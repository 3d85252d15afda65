"""Small scenes with known answers, and awkward meshes that people really bring."""

import numpy as np
import trimesh

import exact

HEIGHT = 400.0


def above(x=0.0, y=0.0, height=HEIGHT, fov=(400.0, 400.0), target_height=0.0):
    """A camera at (x, y, height) that looks straight down; its field of view is measured at `target_height`."""
    return exact.Camera.look_at((x, y, height), (x, y, target_height), up=(0, 1, 0), fov=fov)


def rectangle(x, y, z=0.0, up=True):
    """Two triangles over the intervals x and y; z is a height or a function of (x, y)."""
    height = z if callable(z) else lambda *_: z
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    faces = [[0, 1, 2], [0, 2, 3]] if up else [[0, 2, 1], [0, 3, 2]]
    return trimesh.Trimesh([[*corner, height(*corner)] for corner in corners], faces, process=False)


def together(*parts):
    """Several meshes as one, nothing merged."""
    return trimesh.util.concatenate(parts)


def tilted_tori():
    """Two tori that cut through each other, each closed."""
    first = trimesh.creation.torus(7, 2.5, major_sections=40, minor_sections=24)
    second = first.copy()
    second.apply_transform(trimesh.transformations.rotation_matrix(1.1, (1, 1, 0.2)))
    second.apply_translation((3, 2, 1))
    return first, second


def half_shell():
    """An open bowl, its outside up: backs and a border."""
    return trimesh.creation.icosphere(3, radius=9.0).slice_plane((0, 0, 2), (0.1, 0.2, -1))


def slivers():
    """A closed cylinder whose wall is made of long thin faces, and whose caps are fans."""
    return trimesh.creation.cylinder(8.0, 40.0, sections=300)


def soup():
    """Thirty triangles anywhere, cutting each other."""
    rng = np.random.default_rng(7)
    corners = rng.uniform(-10, 10, (30, 1, 3)) + rng.normal(0, 4, (30, 3, 3))
    return trimesh.Trimesh(corners.reshape(-1, 3), np.arange(90).reshape(-1, 3), process=False)


def stacked_boxes():
    """Boxes that touch along faces, edges and corners."""
    places = [(0, 0, 0), (6, 0, 0), (0, 6, 6), (6, 6, 0), (-6, 6, 6), (0, 0, 6)]
    return together(*(trimesh.creation.box((6, 6, 6)).apply_translation(place) for place in places))


def block_with_channel():
    """A closed block with a slanted square channel through it and a bar across, by solid booleans."""
    channel = trimesh.creation.box((9, 9, 60))
    channel.apply_transform(trimesh.transformations.rotation_matrix(0.2, (1, 0.3, 0)))
    bar = trimesh.creation.box((40, 3, 3)).apply_translation((0, 1, 6))
    block = trimesh.boolean.difference([trimesh.creation.box((30, 30, 30)), channel], engine="manifold")
    return trimesh.boolean.union([block, bar], engine="manifold")


def with_t_junctions():
    """A step whose neighbouring rectangles do not share all their vertices."""
    floor = [rectangle((-9, 0), (-9, 9)), rectangle((0, 9), (-9, 2)), rectangle((0, 9), (2, 9))]
    return together(*floor, rectangle((-3, 5), (-4, 4), lambda x, y: 6 + 0.3 * x))


AWKWARD = {
    "intersecting shells": lambda: together(*tilted_tori()),
    "open": half_shell,
    "slivers": slivers,
    "soup": soup,
    "touching boxes": stacked_boxes,
    "channel": block_with_channel,
    "T-junctions": with_t_junctions,
}
