"""Call the exact evaluator from your own program: any cameras, any threshold, and the part they reconstruct.

Run it as: python exact_area.py scan.stl seen.ply
"""

import sys

import exact
import meshes


def main(path: str, out: str) -> exact.Reconstruction:
    """Write the part of the surface in the file `path` [mm] that at least two of three cameras see."""
    mesh = meshes.load(path)
    cameras = [
        exact.Camera.look_at(position, target=(0, 0, 0), up=(0, 1, 0), fov=(60, 60))
        for position in ((-40, 0, 300), (40, 0, 300), (0, 60, 280))  # anywhere, not only on a ring
    ]
    result = exact.evaluate(mesh, cameras, threshold=2)
    for level, area in enumerate(result.level_areas, start=1):
        print(f"seen by at least {level}: {area:.6f} mm²")
    for number, camera in enumerate(cameras, start=1):
        print(f"camera {number} alone: {exact.view(mesh, camera).area:.6f} mm²")
    result.to_mesh().export(out)
    return result


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
