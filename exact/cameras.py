r"""Pinhole cameras, alone or on a ring (Wachter 2021, section 2.2, Eq. 1 to 4).

::

                 P  (0, 0, r^2/h) above F: every up vector points here
                 |
        C_2 ---- + ---- C_1     ring, diameter d, centre h above F
           \     |     /
            \    h    /  r = sqrt(h^2 + (d/2)^2)
             \   |   /
              \  |  /
                 F              focus: all cameras look here

Lengths in millimetres, angles in radians, right-handed axes, float64.
"""

from dataclasses import dataclass, field

import numpy as np

from exact.errors import ExactError
from exact.whole_numbers import is_whole

# Lengths and coordinates of rings [mm]. Beyond, squares overflow or vanish, and a ring far off falls onto its focus.
SHORTEST, LONGEST = 1e-9, 1e9
# A larger ring angle [rad] is damage: its rounding alone would move a camera.
LARGEST_ANGLE = 1e6
# On one ring. Wachter 2021 takes 360 for all there is to see; tables of pairs of cameras grow with the square.
MOST_CAMERAS = 10_000


def _finite_vector(name: str, value, length: int) -> np.ndarray:
    """`value` as a read-only float64 vector of `length` finite numbers."""
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ExactError(f"{name} is {value!r}; it must be {length} numbers") from error
    if vector.shape != (length,) or not np.isfinite(vector).all():
        raise ExactError(f"{name} is {value!r}; it must be {length} finite numbers")
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


def _length(name: str, value) -> float:
    """`value` as a length [mm] that can be reckoned with."""
    number = _positive(name, value, "mm")
    if not SHORTEST <= number <= LONGEST:
        raise ExactError(f"{name} is {number:g} mm; it must be at least {SHORTEST:g} and at most {LONGEST:g} [mm]")
    return number


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera with a rectangular field of view.

    Build one with `Camera.look_at`, or `Ring.cameras` for a whole ring.

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
    """

    position: np.ndarray
    rotation: np.ndarray
    target_distance: float
    fov: np.ndarray
    resolution: np.ndarray

    @staticmethod
    def look_at(position, target, up, fov=(36.0, 24.0), resolution=(3600, 2400)) -> "Camera":
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
        position = _finite_vector("camera position", position, 3)
        target = _finite_vector("camera target", target, 3)
        up = _finite_vector("camera up vector", up, 3)
        width, height = _finite_vector("fov", fov, 2)
        size = np.array([_positive("fov width", width, "mm"), _positive("fov height", height, "mm")])
        pixels = _finite_vector("resolution", resolution, 2)
        if (pixels <= 0).any():
            raise ExactError(f"resolution is {resolution!r}; both numbers of pixels must be positive")
        distance = float(np.linalg.norm(target - position))
        if distance == 0.0:
            raise ExactError(f"camera position and target are both {tuple(position.tolist())}; they must differ")
        look = (target - position) / distance
        right = np.cross(look, up)
        # Below this sine the image's upright direction would be rounding noise.
        if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(up) or not up.any():
            raise ExactError(
                f"camera up vector {tuple(up.tolist())} is zero or parallel to the optical axis; "
                "give any other direction"
            )
        right = right / np.linalg.norm(right)
        rotation = np.stack([right, np.cross(look, right), look]) + 0.0  # + 0.0 turns -0.0 into 0.0
        for array in (rotation, size):
            array.flags.writeable = False
        return Camera(position, rotation, distance, size, pixels)

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
        matrix = np.array(rigid, dtype=np.float64)
        # A rotation written with single precision is still one; a scale or a mirror image is not.
        rotation_tolerance = 1e-6
        is_rigid = matrix.shape == (4, 4) and np.allclose(matrix[3], [0, 0, 0, 1], atol=0)
        is_rigid = is_rigid and np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=rotation_tolerance)
        if not (is_rigid and np.linalg.det(matrix[:3, :3]) > 0 and np.isfinite(matrix).all()):
            raise ExactError("Camera.moved needs a rigid (4, 4) matrix: a rotation and a shift, nothing else")
        position = matrix[:3, :3] @ self.position + matrix[:3, 3]
        rotation = self.rotation @ matrix[:3, :3].T
        return Camera(position, rotation, self.target_distance, self.fov, self.resolution)


@dataclass(frozen=True)
class Ring:
    """A circle of cameras that all look at one point, the focus.

    Parameters
    ----------
    diameter : float
        Diameter of the ring [mm].
    working_distance : float
        Distance of the ring's plane from the focus, along the axis [mm].
    fov : (2,) tuple of float
        Field of view in the plane through the focus perpendicular to each optical axis:
        width (tangential) and height (radial) [mm]. It turns with the ring angle.
    focus : (3,) tuple of float
        The point all cameras look at [mm].
    axis : (3,) tuple of float
        Direction from the focus to the ring's centre. Ring angle 0 lies towards +x, or, for an axis that is not
        +z, where the shortest rotation that takes +z to the axis carries +x.

    Raises
    ------
    ExactError
        If a length is not positive, one is shorter than 1e-9 or longer than 1e9 mm, or a vector is not finite.

    Examples
    --------
    >>> ring = Ring()
    >>> ring.positions([0.0])
    array([[ 15.,   0., 400.]])
    >>> cameras = ring.cameras(ring.equidistant(4))
    >>> len(cameras)
    4
    """

    diameter: float = 30.0
    working_distance: float = 400.0
    fov: tuple[float, float] = (36.0, 24.0)
    focus: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    _frame: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self):
        def put(name, value):
            object.__setattr__(self, name, value)

        put("diameter", _length("ring diameter", self.diameter))
        put("working_distance", _length("working distance", self.working_distance))
        width, height = _finite_vector("fov", self.fov, 2)
        put("fov", (_length("fov width", width), _length("fov height", height)))
        focus = _finite_vector("focus", self.focus, 3)
        if np.abs(focus).max() > LONGEST:
            raise ExactError(f"focus is {tuple(focus.tolist())}; each coordinate must be at most {LONGEST:g} [mm]")
        put("focus", tuple(focus.tolist()))
        axis = _finite_vector("ring axis", self.axis, 3)
        if not axis.any():
            raise ExactError("ring axis is the zero vector; give the direction from the focus to the ring")
        put("axis", tuple(axis.tolist()))
        if not SHORTEST <= np.linalg.norm(axis) <= LONGEST:
            axis = axis / np.abs(axis).max()  # its square may have overflowed or vanished
        put("_frame", _rotation_from_z(axis / np.linalg.norm(axis)))

    def equidistant(self, n_cameras: int, phase: float = 0.0) -> np.ndarray:
        """Ring angles of `n_cameras` evenly spaced cameras: phase + 2 pi i / n, i = 1..n.

        Returns
        -------
        (n_cameras,) ndarray
            Ring angles [rad].

        Examples
        --------
        >>> np.degrees(Ring().equidistant(4)).tolist()
        [90.0, 180.0, 270.0, 360.0]
        """
        if not (is_whole(n_cameras) and n_cameras >= 1):
            raise ExactError(f"number of cameras is {n_cameras}; it must be a whole number, at least 1")
        if n_cameras > MOST_CAMERAS:
            raise ExactError(f"number of cameras is {n_cameras}; it must be at most {MOST_CAMERAS}")
        return phase + 2 * np.pi * np.arange(1, int(n_cameras) + 1) / int(n_cameras)

    def positions(self, angles) -> np.ndarray:
        """Camera centres.

        Parameters
        ----------
        angles : (M,) array_like
            Ring angles [rad].

        Returns
        -------
        (M, 3) ndarray
            World points [mm]: F + (d/2 cos, d/2 sin, h) in the ring's own frame.
        """
        theta = _checked_angles(angles)
        radius = self.diameter / 2
        local = np.stack(
            [radius * np.cos(theta), radius * np.sin(theta), np.full_like(theta, self.working_distance)], axis=1
        )
        return np.array(self.focus) + local @ self._frame.T

    def cameras(self, angles) -> tuple[Camera, ...]:
        """One camera at each of the (M,) ring angles [rad], all looking at the focus.

        Each up vector points to where the plane perpendicular to the optical axis meets the ring's axis, so that
        the image's width is tangential to the ring and its height radial (Wachter 2021, section 2.2).
        """
        focus = np.array(self.focus)
        distance_squared = self.working_distance**2 + (self.diameter / 2) ** 2
        apex = focus + self._frame[:, 2] * (distance_squared / self.working_distance)
        return tuple(
            Camera.look_at(position, focus, up=apex - position, fov=self.fov) for position in self.positions(angles)
        )

    def separations(self, angles) -> np.ndarray:
        """(M, M) chords between all pairs of the (M,) ring angles [mm]."""
        theta = _checked_angles(angles)
        return self.diameter * np.abs(np.sin((theta[:, None] - theta[None, :]) / 2))


def _checked_angles(angles) -> np.ndarray:
    theta = np.atleast_1d(np.asarray(angles, dtype=np.float64))
    if theta.ndim != 1 or len(theta) == 0:
        raise ExactError(f"ring angles have shape {theta.shape}; they must be one row of at least one angle [rad]")
    if not np.isfinite(theta).all():
        raise ExactError(f"ring angles {theta.tolist()} are not all finite [rad]")
    if len(theta) > MOST_CAMERAS:
        raise ExactError(f"there are {len(theta)} ring angles; a ring holds at most {MOST_CAMERAS} cameras")
    worst = int(np.argmax(np.abs(theta)))
    if abs(theta[worst]) > LARGEST_ANGLE:
        raise ExactError(
            f"ring angle {worst + 1} is {theta[worst]:g} rad; angles must be at most {LARGEST_ANGLE:g} rad to and fro"
        )
    return theta


def _rotation_from_z(direction: np.ndarray) -> np.ndarray:
    """(3, 3) the shortest rotation that takes +z to the unit vector `direction`."""
    x, y, z = direction
    if z < 0 and x == 0 and y == 0:
        return np.diag([1.0, -1.0, -1.0])  # half a turn about +x; every half turn is as short
    skew = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])  # of the vector z cross direction
    # Rodrigues' formula with the factor (1 - cos)/sin^2 = 1/(1 + cos); near -z written without cancellation.
    factor = 1 / (1 + z) if z > 0 else (1 - z) / (x * x + y * y)
    return np.eye(3) + skew + factor * (skew @ skew)
