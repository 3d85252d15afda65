"""Which views are usable and how accurately points are triangulated, point by point, for `ray_oracle`.

It shares no code and no formula with `exact`: pixels are projected with the plain pinhole model, and everything else
follows from their derivatives.
"""

import numpy as np

from tests.support.ray_oracle import blocks

STEP = 1e-3  # of central differences [mm]; pixels are smooth to 1e-9 over it


def usable(samples, camera, resolution, incidence=None, density=None, depths=None, pupil=None, blur=None):
    """(N,) whether the view of that camera, an index, is usable: angles in rad, px/mm², mm and px as in `exact`."""
    centre, _, _, look = samples.cameras[camera]
    found = np.ones(len(samples.points), dtype=bool)
    for some in blocks(len(found)):
        points, normals = samples.points[some], samples.normals[some]
        away = centre - points
        good = np.ones(len(points), dtype=bool)
        if incidence is not None:
            angle = np.arctan2(np.linalg.norm(np.cross(away, normals), axis=1), (away * normals).sum(axis=1))
            good &= angle <= incidence
        if depths is not None:
            depth = (points - centre) @ look
            good &= (depths[0] <= depth) & (depth <= depths[1])
        if blur is not None:
            # Rays from the point through both ends of the pupil meet the plane of sharpness as far apart as this.
            depth, sharp = (points - centre) @ look, np.linalg.norm(centre)
            across = pupil * np.abs(1 - sharp / depth)
            good &= across * (resolution[0] / samples.fov[0]) <= blur
        if density is not None:
            one = np.cross(normals, [0.36, 0.48, 0.8])
            one /= np.linalg.norm(one, axis=1, keepdims=True)
            slopes = _slopes(points, samples, camera, resolution)
            first = np.einsum("nij,nj->ni", slopes, one)
            second = np.einsum("nij,nj->ni", slopes, np.cross(normals, one))
            good &= np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) >= density
        found[some] = good
    return found


def deviations(samples, cameras, resolution, noise):
    """(N,) standard deviations [mm] of points triangulated by these cameras, indices: along depth and the normal.

    Infinite for points that fewer than two of them see.
    """
    found = np.full((2, len(samples.points)), np.inf)
    enough = samples.seen[cameras].sum(axis=0) >= 2
    for some in blocks(len(samples.points)):
        some = some[enough[some]]
        information = np.zeros((len(some), 3, 3))
        for camera in cameras:
            slopes = _slopes(samples.points[some], samples, camera, resolution)
            slopes *= samples.seen[camera, some, None, None]
            information += np.swapaxes(slopes, 1, 2) @ slopes / noise**2
        covariance = np.linalg.inv(information)
        normals = samples.normals[some]
        found[0, some] = np.sqrt(covariance[:, 2, 2])
        found[1, some] = np.sqrt(np.einsum("ni,nij,nj->n", normals, covariance, normals))
    return found


def disparity_gradients(samples, one, other):
    """(N,) by how much disparity changes across an image of the surface at each sample, of two cameras, indices.

    In the image of a camera half way between the two that looks as both do, rectified: the disparity of a point is the
    baseline over its depth, in units of the focal length.
    """
    (first, *_, look_of_first), (second, *_, look_of_second) = samples.cameras[one], samples.cameras[other]
    baseline = np.linalg.norm(second - first)
    x = (second - first) / baseline
    y = np.cross(look_of_first + look_of_second, x)
    y /= np.linalg.norm(y)
    frame = np.stack([x, y, np.cross(x, y)])

    def image(points):
        across, upright, depth = frame @ (points - (first + second) / 2).T
        return np.stack([across / depth, upright / depth, baseline / depth])

    found = np.empty(len(samples.points))
    for some in blocks(len(found)):
        points, normals = samples.points[some], samples.normals[some]
        along = np.cross(normals, [0.36, 0.48, 0.8])
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        ways = [STEP * direction for direction in (along, np.cross(normals, along))]
        (a, b, one_way), (c, d, other_way) = [image(points + way) - image(points - way) for way in ways]
        # The two changes of the disparity from those of the image: solved for its gradient, by Cramer's rule.
        across, upright = d * one_way - b * other_way, a * other_way - c * one_way
        found[some] = np.hypot(across, upright) / np.abs(a * d - b * c)
    return found


def _slopes(points, samples, camera, resolution):
    """(N, 2, 3) change of the pixel with the point [px/mm], by central differences."""
    shift = STEP * np.eye(3)
    ends = [
        _pixels(points + shift[i], samples, camera, resolution)
        - _pixels(points - shift[i], samples, camera, resolution)
        for i in range(3)
    ]
    return np.stack(ends, axis=2) / (2 * STEP)


def _pixels(points, samples, camera, resolution):
    centre, tangential, radial, look = samples.cameras[camera]
    away = points - centre
    magnified = np.linalg.norm(centre) / (away @ look)  # onto the plane through the focus
    return np.stack(
        [
            away @ tangential * magnified * (resolution[0] / samples.fov[0]),
            away @ radial * magnified * (resolution[1] / samples.fov[1]),
        ],
        axis=1,
    )
