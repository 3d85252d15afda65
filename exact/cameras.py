"""Pinhole cameras (Wachter 2021, section 2.2, Eq. 1 to 4).

Lengths in millimetres, angles in radians, right-handed axes, float64.
"""

from dataclasses import dataclass

import numpy as np

from exact.errors import ExactError

# Lengths and coordinates [mm]. Beyond, squares overflow or vanish, and a ring far off falls onto its focus.
SHORTEST, LONGEST = 1e-9, 1e9
# Farther off [mm] no camera stands: one on the longest ring at the farthest focus is nearer.
FARTHEST = 4 * LONGEST
# Pixels of a camera unless it is said otherwise.
RESOLUTION = (3600, 2400)
# A rotation written with single precision is still one; a scale or a mirror image is not.
ROTATION_TOLERANCE = 1e-6


def finite_vector(name: str, value, n_numbers: int) -> np.ndarray:
    """`value` as a read-only float64 vector of `n_numbers` finite numbers."""
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ExactError(f"{name} is {value!r}; it must be {n_numbers} numbers") from error
    if vector.shape != (n_numbers,) or not np.isfinite(vector).all():
        raise ExactError(f"{name} is {value!r}; it must be {n_numbers} finite numbers")
    vector.flags.writeable = False
    return vector


def _positive(name: str, value, unit: str) -> float:
    """`value` as a positive finite float."""
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise ExactError(f"{name} is {value!r}; it must be a number [{unit}]") from error
    except OverflowError:  # a whole number of hundreds of digits
        number = np.inf
    if isinstance(value, bool | np.bool):
        raise ExactError(f"{name} is {value}; it must be a number [{unit}]")
    if not (np.isfinite(number) and number > 0):
        shown = number if np.isinf(number) else value
        raise ExactError(f"{name} is {shown}; it must be positive and finite [{unit}]")
    return number


def length(name: str, value) -> float:
    """`value` as a length [mm] that can be reckoned with."""
    number = _positive(name, value, "mm")
    if not SHORTEST <= number <= LONGEST:
        raise ExactError(f"{name} is {number:g} mm; it must be at least {SHORTEST:g} and at most {LONGEST:g} [mm]")
    return number


def _position(name: str, value) -> np.ndarray:
    """`value` as a read-only point [mm] that can be reckoned with."""
    point = finite_vector(name, value, 3)
    if np.abs(point).max() > FARTHEST:
        raise ExactError(f"{name} is {tuple(point.tolist())}; each coordinate must be at most {FARTHEST:g} [mm]")
    return point


def _is_rotation(matrix: np.ndarray) -> bool:
    """Whether a finite matrix turns space and does nothing else."""
    turned = matrix.shape == (3, 3) and np.isfinite(matrix).all() and (np.abs(matrix) < 2).all()
    return bool(
        turned and np.allclose(matrix @ matrix.T, np.eye(3), atol=ROTATION_TOLERANCE) and np.linalg.det(matrix) > 0
    )


def _matrix(value) -> np.ndarray:
    """`value` as a float64 array of its own, empty if it holds no numbers."""
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        return np.zeros(0)


def looking(positions: np.ndarray, target: np.ndarray, ups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotations of cameras that all look at one point, and their distances from it; errors as for `Camera.look_at`.

    Parameters
    ----------
    positions, ups : (M, 3) float
        Where each camera is [mm], and what is upright in its image.
    target : (3,) float [mm]

    Returns
    -------
    rotations : (M, 3, 3) float
    distances : (M,) float [mm]
    """
    distances = _lengths(target - positions)
    if not distances.all():
        here = tuple(positions[np.argmin(distances)].tolist())
        raise ExactError(f"camera position and target are both {here}; they must differ")
    look = (target - positions) / distances[:, None]
    right = np.cross(look, ups)
    # Below this sine the image's upright direction would be rounding noise.
    unclear = (_lengths(right) <= 1e-9 * _lengths(ups)) | ~ups.any(axis=1)
    if unclear.any():
        raise ExactError(
            f"camera up vector {tuple(ups[np.argmax(unclear)].tolist())} is zero or parallel to the optical axis; "
            "give any other direction"
        )
    right = right / _lengths(right)[:, None]
    # + 0.0 turns -0.0 into 0.0
    return np.stack([right, np.cross(look, right), look], axis=1) + 0.0, distances


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """(M,) lengths of (M, 3) vectors, each the same however many there are, to the last bit."""
    return np.sqrt(np.vecdot(vectors, vectors))


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera with a rectangular field of view.

    Build one with `Camera.look_at`, or `Ring.cameras` for a whole ring. Its arrays are copies of those given, and
    cannot be written to.

    Attributes
    ----------
    position : (3,) ndarray
        Centre of projection [mm].
    rotation : (3, 3) ndarray
        World to camera; its rows are the camera's axes right, down and look in world coordinates.
    target_distance : float
        Distance from `position` to the plane in which `fov` is measured [mm].
    fov : (2,) ndarray
        Width (along right) and height (along down) of the field of view in the plane
        through the target perpendicular to the optical axis [mm].
    resolution : (2,) ndarray
        Pixels along right and down. It scales `intrinsic`; it never changes an area.

    Raises
    ------
    ExactError
        If an array has the wrong shape or is not finite, a length or a number of pixels is not positive, a coordinate
        is larger than 4e9 mm, or `rotation` is none.

    Examples
    --------
    >>> camera = Camera([0, 0, 400], [[1, 0, 0], [0, -1, 0], [0, 0, -1]], 400, (36, 24), (3600, 2400))
    >>> camera.project([[18.0, 12.0, 0.0]])
    array([[3600.,    0.]])
    >>> Camera([0, 0, 400], np.eye(2), 400, (36, 24), (3600, 2400))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    exact.errors.ExactError: camera rotation is an array of shape (2, 2), ...
    """

    position: np.ndarray
    rotation: np.ndarray
    target_distance: float
    fov: np.ndarray
    resolution: np.ndarray

    def __post_init__(self):
        def put(name, value):
            object.__setattr__(self, name, value)

        put("position", _position("camera position", self.position))
        rotation = _matrix(self.rotation)
        if not _is_rotation(rotation):
            raise ExactError(
                f"camera rotation is an array of shape {rotation.shape}, {rotation.tolist()}; it must be a (3, 3) "
                "rotation, whose rows are the camera's axes right, down and look: Camera.look_at makes one"
            )
        rotation.flags.writeable = False
        put("rotation", rotation)
        distance = _positive("target distance", self.target_distance, "mm")
        if distance > FARTHEST:
            raise ExactError(f"target distance is {distance:g} mm; it must be at most {FARTHEST:g} [mm]")
        put("target_distance", distance)
        put("fov", finite_vector("fov", self.fov, 2))
        for name, side in zip(("fov width", "fov height"), self.fov, strict=True):
            _positive(name, side, "mm")
        put("resolution", finite_vector("resolution", self.resolution, 2))
        if (self.resolution <= 0).any():
            raise ExactError(
                f"resolution is {tuple(self.resolution.tolist())}; both numbers of pixels must be positive"
            )

    @staticmethod
    def look_at(position, target, up, fov=(36.0, 24.0), resolution=RESOLUTION) -> "Camera":
        """Camera at `position` looking at `target`, its image upright along `up`.

        Parameters
        ----------
        position, target : (3,) array_like
            World points [mm]; they must differ.
        up : (3,) array_like
            Any direction not parallel to the optical axis; only its part perpendicular to it counts.
        fov : (2,) array_like
            Width and height of the field of view at the target [mm].
        resolution : (2,) array_like
            Pixels across the width and the height.

        Raises
        ------
        ExactError
            If `position` equals `target`, `up` is parallel to the optical axis, or a number is not finite.

        Examples
        --------
        >>> camera = Camera.look_at((0, 0, 400), target=(0, 0, 0), up=(0, 1, 0), fov=(36, 24))
        >>> camera.rotation[2]  # looks down
        array([ 0.,  0., -1.])
        >>> camera.project([[18.0, 12.0, 0.0]])  # the upper right corner of the field of view [pixels]
        array([[3600.,    0.]])
        """
        position, target = _position("camera position", position), _position("camera target", target)
        up = finite_vector("camera up vector", up, 3)
        (rotation,), (distance,) = looking(position[None], target, up[None])
        return Camera(position, rotation, distance, fov, resolution)

    @property
    def half_extent(self) -> np.ndarray:
        """(2,) half width and half height of the field of view at unit depth, the tangents of its half angles."""
        return 0.5 * self.fov / self.target_distance

    @property
    def intrinsic(self) -> np.ndarray:
        """(3, 3) camera coordinates to homogeneous pixels (Wachter 2021, Eq. 1 and 2).

        The paper writes the focal length in pixels as image distance x resolution / sensor size. With the field
        of view given at the target this is target distance x resolution / fov, whatever the sensor.
        """
        focal = self.target_distance * self.resolution / self.fov
        centre = self.resolution / 2
        return np.array([[focal[0], 0.0, centre[0]], [0.0, focal[1], centre[1]], [0.0, 0.0, 1.0]])

    @property
    def extrinsic(self) -> np.ndarray:
        """(4, 4) rigid transform from world to camera coordinates: right, down, look (Wachter 2021, Eq. 3)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = -self.rotation @ self.position
        return matrix

    @property
    def projection(self) -> np.ndarray:
        """(3, 4) world to homogeneous pixels: intrinsic x extrinsic (Wachter 2021, Eq. 4)."""
        return self.intrinsic @ self.extrinsic[:3]

    def project(self, points) -> np.ndarray:
        """Pixel coordinates of world `points`.

        Parameters
        ----------
        points : (N, 3) array_like
            World points [mm].

        Returns
        -------
        (N, 2) ndarray
            x to the right and y down [pixels], the image's upper left corner at (0, 0). A point in the plane of
            the camera or behind it has no image: nan.
        """
        local = (np.asarray(points, dtype=np.float64) - self.position) @ self.rotation.T
        depth = np.where(local[:, 2] > 0, local[:, 2], np.nan)
        return (local / depth[:, None]) @ self.intrinsic[:2].T

    def moved(self, rigid) -> "Camera":
        """Return the same camera carried along by a rigid motion.

        Parameters
        ----------
        rigid : (4, 4) array_like
            Rotation and shift [mm] in homogeneous coordinates; no scaling, no mirroring.

        Examples
        --------
        >>> camera = Camera.look_at((0, 0, 400), target=(0, 0, 0), up=(0, 1, 0))
        >>> shift = np.eye(4)
        >>> shift[0, 3] = 10.0
        >>> camera.moved(shift).position
        array([ 10.,   0., 400.])
        """
        matrix = _matrix(rigid)
        is_rigid = matrix.shape == (4, 4) and np.isfinite(matrix).all()
        is_rigid = is_rigid and np.allclose(matrix[3], [0, 0, 0, 1], atol=0) and _is_rotation(matrix[:3, :3])
        if not is_rigid:
            raise ExactError("Camera.moved needs a rigid (4, 4) matrix: a rotation and a shift, nothing else")
        position = matrix[:3, :3] @ self.position + matrix[:3, 3]
        rotation = self.rotation @ matrix[:3, :3].T
        return Camera(position, rotation, self.target_distance, self.fov, self.resolution)
