"""Turn the images of two cameras so that each point lies in the same row of both."""

from dataclasses import dataclass

import cv2
import numpy as np

import exact

# Room around the depths that are looked for, on either side [pixels of disparity].
ROOM = 8
# The matcher takes ranges of disparities that are multiples of this.
STEP = 16


@dataclass(frozen=True, eq=False)
class Rectified:
    """Two cameras turned to look in the same direction, across the line between them.

    With `focal` and the baseline b, a point at depth Z along that direction has the disparity f b / Z - `first`.

    Attributes
    ----------
    rotation : (3, 3) ndarray
        World to the axes that both share: along the baseline, down, look.
    focal, baseline : float
        Focal length [pixels], distance between the cameras [mm].
    first : int
        The least disparity, of the greatest depth; all that the images show is shifted by it.
    n_disparities : int
        How many there are, a multiple of 16.
    size : (int, int)
        Width and height of the turned images [pixels].
    homographies : pair of (3, 3) ndarray
        From pixels of each camera's image to pixels of its turned one, pixel centres at whole numbers.
    """

    rotation: np.ndarray
    focal: float
    baseline: float
    first: int
    n_disparities: int
    size: tuple[int, int]
    homographies: tuple[np.ndarray, np.ndarray]

    @staticmethod
    def of(one: exact.Camera, two: exact.Camera, depths: tuple[float, float]) -> "Rectified":
        """For two cameras whose `resolution` is that of their images, and points at these depths [mm].

        Examples
        --------
        >>> cameras = exact.Ring().cameras([0.0, np.pi])
        >>> found = Rectified.of(*cameras, (390.0, 410.0))
        >>> round(found.baseline, 6), found.n_disparities % 16
        (30.0, 0)
        """
        along = two.position - one.position
        baseline = float(np.linalg.norm(along))
        x = along / baseline
        look = one.rotation[2] + two.rotation[2]
        z = look - (look @ x) * x
        z /= np.linalg.norm(z)
        rotation = np.stack([x, np.cross(z, x), z])
        focal = float(np.mean([camera.intrinsic[[0, 1], [0, 1]] for camera in (one, two)]))
        first = int(np.floor(focal * baseline / max(depths))) - ROOM
        needed = focal * baseline / min(depths) - first + ROOM
        n_disparities = STEP * int(np.ceil(needed / STEP))
        plain = np.diag([focal, focal, 1.0])
        turned = [plain @ rotation @ camera.rotation.T @ np.linalg.inv(_centred(camera)) for camera in (one, two)]
        turned[1] = np.array([[1.0, 0.0, first], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) @ turned[1]
        corners = [_corners(matrix, camera) for matrix, camera in zip(turned, (one, two), strict=True)]
        # What both show, with room for all disparities where the matcher looks for them: on either side.
        low = np.max([corner.min(axis=0) for corner in corners], axis=0) - [n_disparities, 0]
        high = np.min([corner.max(axis=0) for corner in corners], axis=0) + [n_disparities, 0]
        low = np.floor(low)
        width, height = np.maximum(np.ceil(high - low).astype(int), 1)
        shift = np.array([[1.0, 0.0, -low[0]], [0.0, 1.0, -low[1]], [0.0, 0.0, 1.0]])
        return Rectified(
            rotation, focal, baseline, first, n_disparities, (int(width), int(height)),
            (shift @ turned[0], shift @ turned[1]),
        )  # fmt: skip

    def turned(self, image: np.ndarray, which: int) -> np.ndarray:
        """The image (H, W) of the first or second camera (0 or 1), turned; 0 beyond its border."""
        return cv2.warpPerspective(image, self.homographies[which], self.size, flags=cv2.INTER_CUBIC)

    def inside(self, shape: tuple[int, ...], which: int, window: int) -> np.ndarray:
        """(h, w) bool: around which pixels of a turned image a window shows nothing but the image, (H, W) = `shape`."""
        whole = cv2.warpPerspective(np.full(shape, 255, dtype=np.uint8), self.homographies[which], self.size)
        return cv2.erode(whole, np.ones((window, window), dtype=np.uint8), borderValue=0) == 255

    def depth(self, disparity: np.ndarray) -> np.ndarray:
        """Depths [mm] along the shared direction."""
        return self.focal * self.baseline / (disparity + self.first)

    def at(self, pixels: np.ndarray, which: int) -> np.ndarray:
        """(N, 2) where pixels (N, 2) of a camera's image lie in its turned one; pixel centres at whole numbers."""
        return _through(self.homographies[which], pixels)


def _centred(camera: exact.Camera) -> np.ndarray:
    """Its intrinsic matrix with pixel centres at whole numbers, as OpenCV counts."""
    matrix = camera.intrinsic.copy()
    matrix[:2, 2] -= 0.5
    return matrix


def _corners(matrix: np.ndarray, camera: exact.Camera) -> np.ndarray:
    width, height = camera.resolution - 1
    return _through(matrix, np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float64))


def _through(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    mapped = points @ matrix[:, :2].T + matrix[:, 2]
    return mapped[:, :2] / mapped[:, 2:]
