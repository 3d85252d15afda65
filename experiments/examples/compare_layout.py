"""Compare a layout of your own with the equidistant one, camera by camera and as a whole.

Run it as: python compare_layout.py circ_artery 10 95 170 280
"""

import sys

import numpy as np

import exact
import meshes


def main(site: str, angles_deg: list[float]) -> tuple[float, float]:
    """Exact areas [mm²] of the layout and of as many equidistant cameras, on a reference site without its top."""
    mesh = meshes.site(site, depth=50)
    ring = exact.Ring()
    layouts = {"yours": np.radians(angles_deg), "equidistant": ring.equidistant(len(angles_deg))}
    areas = []
    for name, angles in layouts.items():
        seen = exact.evaluate(mesh, ring.cameras(angles), threshold=2, exclude=meshes.top_surface(mesh))
        areas.append(seen.area)
        once = seen.level_areas[0] - seen.area
        print(f"{name:12s} {seen.area:10.3f} mm² reconstructable, {once:8.3f} mm² seen by one camera only")
    print(f"difference   {areas[0] - areas[1]:+10.3f} mm²")
    return areas[0], areas[1]


if __name__ == "__main__":
    main(sys.argv[1], [float(word) for word in sys.argv[2:]])
