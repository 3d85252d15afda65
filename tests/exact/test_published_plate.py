"""A plate with a polygonal hole: 20 numbers worked out independently of any published code, from published areas.

The areas of the circular sites with and without top surface differ by what is reconstructable of the top surface,
which is a flat plate with a hole (Wachter 2021, Tables A1 to A3).
"""

import csv

import numpy as np
import pytest
import shapely
import trimesh

import exact
from tests.support import PUBLISHED_AREAS

CAMERA_COUNTS = (2, 4, 6, 8, 16, 32, 64, 128, 256, 360)
# The tables give areas to 0.01 mm²; a difference of two of them is known to 0.01, the hole's radius to a little more.
TOLERANCE = 0.02


def published_top_surface(depth):
    """Published area with, less the one without top surface, for each camera count [mm²]."""
    with PUBLISHED_AREAS.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 240
    area = {
        (int(row["n_cameras"]), row["top_surface_included"]): float(row["area_mm2"])
        for row in rows
        if row["site"] == "circ_flat" and row["depth_mm"] == str(depth) and row["fov_mm"] == "36x24"
    }
    return {n: area[n, "1"] - area[n, "0"] for n in CAMERA_COUNTS}


def plate(depth, corners):
    angle = 2 * np.pi * np.arange(corners) / corners
    hole = 12.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outline = shapely.box(-40, -40, 40, 40).difference(shapely.Polygon(hole))
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(outline))
    xy = shapely.get_coordinates(shapely.normalize(triangles)).reshape(-1, 4, 2)[:, :3]
    xy = np.where((np.linalg.det(xy[:, 1:] - xy[:, :1]) > 0)[:, None, None], xy, xy[:, ::-1])
    points = np.concatenate([xy.reshape(-1, 2), np.full((3 * len(xy), 1), float(depth))], axis=1)
    return trimesh.Trimesh(points, np.arange(len(points)).reshape(-1, 3), process=False)


@pytest.mark.parametrize(("depth", "corners"), [(50, 39), (100, 34)])
@pytest.mark.parametrize("n_cameras", CAMERA_COUNTS)
def test_published_top_surface(depth, corners, n_cameras):
    ring = exact.Ring()
    result = exact.evaluate(plate(depth, corners), ring.cameras(ring.equidistant(n_cameras)), threshold=2)
    assert result.area == pytest.approx(published_top_surface(depth)[n_cameras], abs=TOLERANCE)
    assert result.repairs == 0
