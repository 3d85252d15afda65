r"""A circle of cameras around a focus (Wachter 2021, section 2.2).

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
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from exact.cameras import LONGEST, RESOLUTION, SHORTEST, Camera, finite_vector, length, looking
from exact.errors import ExactError
from exact.whole_numbers import is_whole

# A larger ring angle [rad] is damage: its rounding alone would move a camera.
LARGEST_ANGLE = 1e6
# A direction that differs by less than this [rad] from the axis is along it: written with a few digits, it has no
# direction across.
ALONG = 1e-6
# On one ring. Wachter 2021 takes 360 for all there is to see; tables of pairs of cameras grow with the square.
MOST_CAMERAS = 10_000
# Rolls that have a name, as a turn out of the radial one [rad]; of free ones unless each camera's is given.
NAMED_ROLLS = {"radial": 0.0, "tangential": np.pi / 2, "free": 0.0}
ROLL_WORDS = ", ".join(f'"{name}"' for name in NAMED_ROLLS)


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
        width and height [mm]. How it lies is said by `roll`.
    focus : (3,) tuple of float
        The point all cameras look at [mm].
    axis : (3,) tuple of float
        Direction from the focus to the ring's centre.
    zero_towards : (3,) tuple of float, optional
        Direction in which ring angle 0 lies, as far as it is across the axis. Unless given, +x, or, for an axis that is
        not +z, where the shortest rotation that takes +z to the axis carries +x.
    roll : "radial", "tangential", "free" or float
        How each sensor is turned about its optical axis. "radial": the height of the image is radial and its width
        tangential (Wachter 2021), so that the field of view turns with the ring angle. "tangential": a quarter turn
        from that. A number: the width of every image lies along one direction in space, as far as that is across the
        optical axis, namely along the ring angle of that number [rad]. "free": each camera has a roll of its own,
        which `placement.optimise` chooses; where none is given, as of equidistant cameras, it is radial.

    Raises
    ------
    ExactError
        If a length is not positive, one is shorter than 1e-9 or longer than 1e9 mm, a vector is not finite,
        `zero_towards` is along the axis, or `roll` is none of these.

    Examples
    --------
    >>> [float(one.project([[10.0, 0.0, 0.0]])[0, 1].round(9)) for one in Ring(roll=0.0).cameras([0.0, 1.0, 2.0])]
    [1200.0, 1200.0, 1200.0]
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
    zero_towards: tuple[float, float, float] | None = None
    roll: str | float = "radial"
    _frame: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self):
        def put(name, value):
            object.__setattr__(self, name, value)

        put("diameter", length("ring diameter", self.diameter))
        put("working_distance", length("working distance", self.working_distance))
        width, height = finite_vector("fov", self.fov, 2)
        put("fov", (length("fov width", width), length("fov height", height)))
        focus = finite_vector("focus", self.focus, 3)
        if np.abs(focus).max() > LONGEST:
            raise ExactError(f"focus is {tuple(focus.tolist())}; each coordinate must be at most {LONGEST:g} [mm]")
        put("focus", tuple(focus.tolist()))
        axis = finite_vector("ring axis", self.axis, 3)
        if not axis.any():
            raise ExactError("ring axis is the zero vector; give the direction from the focus to the ring")
        put("axis", tuple(axis.tolist()))
        if not isinstance(self.roll, str):
            put("roll", _angle("roll", self.roll, f"{ROLL_WORDS} or a number"))
        elif self.roll not in NAMED_ROLLS:
            raise ExactError(f"roll is {self.roll!r}; it must be {ROLL_WORDS} or a number [rad]")
        unit = _unit(axis)
        if self.zero_towards is None:
            put("_frame", _rotation_from_z(unit))
            return
        towards = finite_vector("zero_towards", self.zero_towards, 3)
        put("zero_towards", tuple(towards.tolist()))
        across = _unit(towards) - (_unit(towards) @ unit) * unit
        if np.linalg.norm(across) < ALONG:
            raise ExactError(
                f"zero_towards is {self.zero_towards}, which lies along the ring axis {self.axis}; give a direction "
                "across it"
            )
        zero = _unit(across)
        put("_frame", np.column_stack([zero, np.cross(unit, zero), unit]))

    @property
    def frame(self) -> np.ndarray:
        """(3, 3) unit vectors in columns: towards ring angle 0, towards a quarter turn, and along the axis.

        Examples
        --------
        >>> Ring(axis=(0, 0, 2)).frame[:, 2]
        array([0., 0., 1.])
        """
        return self._frame.copy()

    def equidistant(self, n_cameras: int, phase: float = 0.0) -> np.ndarray:
        """Ring angles of `n_cameras` evenly spaced cameras: phase + 2 pi i / n, i = 1..n.

        Parameters
        ----------
        n_cameras : int
            From 1 to 10 000.
        phase : float
            By how much all are turned [rad].

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
        return _checked_phase(phase) + 2 * np.pi * np.arange(1, int(n_cameras) + 1) / int(n_cameras)

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

    def cameras(self, angles, rolls: ArrayLike | None = None) -> tuple[Camera, ...]:
        """Cameras at ring angles, all looking at the focus.

        The up vector of a camera without roll points to where the plane perpendicular to the optical axis meets the
        ring's axis, so that the image's width is tangential to the ring and its height radial (Wachter 2021, section
        2.2).

        Parameters
        ----------
        angles : (M,) array_like
            Ring angles [rad].
        rolls : (M,) array_like, optional
            By how much each camera is turned about its optical axis out of the radial position, clockwise as it looks
            [rad]; as `roll` says unless given.

        Returns
        -------
        (M,) tuple of Camera

        Examples
        --------
        >>> ring = Ring()
        >>> (radial,), (turned,) = ring.cameras([1.0]), ring.cameras([1.0], rolls=[np.pi / 2])
        >>> bool(np.allclose(turned.rotation[0], radial.rotation[1]))  # right is now what was down
        True
        """
        fov, resolution = np.array(self.fov), np.array(RESOLUTION)
        return tuple(
            Camera(position, rotation, distance, fov, resolution)
            for position, rotation, distance in zip(*poses(self, angles, rolls), strict=True)
        )

    def rolls(self, angles) -> np.ndarray:
        """By how much `roll` turns the cameras at ring angles about their optical axes, out of the radial position.

        Parameters
        ----------
        angles : (M,) array_like
            Ring angles [rad].

        Returns
        -------
        (M,) ndarray
            Rolls [rad], as `cameras` takes them.

        Examples
        --------
        >>> np.degrees(Ring(roll=0.0).rolls([0.0, np.pi / 2])).round(9).tolist()
        [90.0, 180.0]
        """
        if isinstance(self.roll, str):
            return np.full(len(_checked_angles(angles)), NAMED_ROLLS[self.roll])
        right, down, _ = np.moveaxis(_radial_poses(self, angles).rotations, 1, 0)
        along = self._frame[:, :2] @ [np.cos(self.roll), np.sin(self.roll)]
        return np.arctan2(down @ along, right @ along)

    def separations(self, angles) -> np.ndarray:
        """(M, M) chords between all pairs of the (M,) ring angles [mm]."""
        theta = _checked_angles(angles)
        return self.diameter * np.abs(np.sin((theta[:, None] - theta[None, :]) / 2))


class Poses(NamedTuple):
    """How M cameras of a ring stand, as arrays, for those who ask about so many that a `Camera` for each takes long."""

    positions: np.ndarray
    """(M, 3) [mm]."""
    rotations: np.ndarray
    """(M, 3, 3), world to camera."""
    distances: np.ndarray
    """(M,) from the focus [mm]."""


def poses(ring: Ring, angles, rolls: ArrayLike | None = None) -> Poses:
    """Poses of `ring.cameras`, for (M,) ring angles and rolls [rad]."""
    radial = _radial_poses(ring, angles)
    if rolls is None and ring.roll in ("radial", "free"):
        return radial
    turns = ring.rolls(angles) if rolls is None else _checked_rolls(rolls, len(radial.positions))
    right, down, look = np.moveaxis(radial.rotations, 1, 0)
    cosine, sine = np.cos(turns)[:, None], np.sin(turns)[:, None]
    turned = np.stack([cosine * right + sine * down, cosine * down - sine * right, look], axis=1) + 0.0
    return radial._replace(rotations=turned)


def _radial_poses(ring: Ring, angles) -> Poses:
    focus, positions = np.array(ring.focus), ring.positions(angles)
    distance_squared = ring.working_distance**2 + (ring.diameter / 2) ** 2
    apex = focus + ring.frame[:, 2] * (distance_squared / ring.working_distance)
    return Poses(positions, *looking(positions, focus, apex - positions))


def _checked_phase(phase) -> float:
    return _angle("phase", phase, "a number")


def _angle(name: str, value, needed: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ExactError(f"{name} is {value!r}; it must be {needed} [rad]") from error
    if not abs(number) <= LARGEST_ANGLE:  # written so that nan is refused
        raise ExactError(f"{name} is {number:g}; it must be from {-LARGEST_ANGLE:g} to {LARGEST_ANGLE:g} [rad]")
    return number


def _checked_rolls(rolls, n_cameras: int) -> np.ndarray:
    try:
        turns = np.asarray(rolls, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ExactError(f"rolls are {rolls!r}; they must be {n_cameras} numbers, one for each camera [rad]") from error
    if turns.shape != (n_cameras,) or not (np.abs(turns) <= LARGEST_ANGLE).all():
        raise ExactError(
            f"rolls are {np.array2string(turns, threshold=8)}; they must be {n_cameras} numbers, one for each camera, "
            f"from {-LARGEST_ANGLE:g} to {LARGEST_ANGLE:g} [rad]"
        )
    return turns


def _checked_angles(angles) -> np.ndarray:
    try:
        theta = np.atleast_1d(np.asarray(angles, dtype=np.float64))
    except (TypeError, ValueError, OverflowError) as error:
        raise ExactError(f"ring angles are {angles!r}; they must be one row of numbers [rad]") from error
    if theta.ndim != 1 or len(theta) == 0:
        raise ExactError(f"ring angles have shape {theta.shape}; they must be one row of at least one angle [rad]")
    if not np.isfinite(theta).all():
        raise ExactError(f"ring angles {theta.tolist()} are not all finite [rad]")
    if len(theta) > MOST_CAMERAS:
        raise ExactError(f"there are {len(theta)} ring angles; a ring holds at most {MOST_CAMERAS} cameras")
    worst = int(np.argmax(np.abs(theta)))
    if abs(theta[worst]) > LARGEST_ANGLE:
        raise ExactError(
            f"ring angle {worst + 1} is {theta[worst]:g} rad; it must be at least {-LARGEST_ANGLE:g} and at most "
            f"{LARGEST_ANGLE:g}"
        )
    return theta


def _unit(vector: np.ndarray) -> np.ndarray:
    """The unit vector (3,) along one that is not 0."""
    vector = np.asarray(vector)
    if not SHORTEST <= np.linalg.norm(vector) <= LONGEST:
        vector = vector / max(np.abs(vector).max(), np.finfo(float).tiny)  # its square may have overflowed or vanished
    length = np.linalg.norm(vector)
    return vector / length if length > 0 else vector


def _rotation_from_z(direction: np.ndarray) -> np.ndarray:
    """(3, 3) the shortest rotation that takes +z to the unit vector `direction`."""
    x, y, z = direction
    if z < 0 and x == 0 and y == 0:
        return np.diag([1.0, -1.0, -1.0])  # half a turn about +x; every half turn is as short
    skew = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])  # of the vector z cross direction
    # Rodrigues' formula with the factor (1 - cos)/sin^2 = 1/(1 + cos); near -z written without cancellation.
    factor = 1 / (1 + z) if z > 0 else (1 - z) / (x * x + y * y)
    return np.eye(3) + skew + factor * (skew @ skew)
