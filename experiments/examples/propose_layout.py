"""Propose a ring layout for your own scan.

Run it as: python propose_layout.py scan.stl 4
"""

import sys

import numpy as np

import exact
import meshes
import placement


def main(path: str, n_cameras: int) -> placement.Placement:
    """Find where `n_cameras` cameras should sit to reconstruct the most of the surface in the file `path` [mm]."""
    mesh = meshes.load(path)
    ring = exact.Ring(diameter=30.0, working_distance=400.0, fov=(36.0, 24.0))
    result = placement.optimise(
        mesh,
        ring,
        n_cameras=n_cameras,
        threshold=2,  # a point is reconstructable when two cameras see it
        constraints=placement.Constraints(min_separation=5.0),  # the housings are 5 mm wide
        seed=0,
    )
    print(f"ring angles [degrees]: {np.degrees(result.angles).round(2).tolist()}")
    print(f"exact area: {result.area:.2f} mm², {100 * result.fraction:.2f} % of the ring maximum")
    print(f"equidistant cameras reconstruct {result.equidistant_area:.2f} mm²")
    return result


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
