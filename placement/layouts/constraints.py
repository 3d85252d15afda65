"""What a layout must respect: room between housings, baselines, fixed cameras, forbidden arcs."""

import math
import sys
from dataclasses import dataclass, replace

import numpy as np

import exact
from exact.ring import LARGEST_ANGLE
from placement.errors import PlacementError, refusing

# Added to the smallest gap [rad] so that a separation computed from rounded angles never falls short of the
# one asked for: 30 nm on a ring of 30 mm.
GAP_MARGIN = 1e-9
# Two numbers that differ by less [mm] count as equal when a finished layout is checked.
LENGTH_TOLERANCE = 1e-9
# What is offered in place of what is infeasible is rounded down to this step [mm, degrees].
OFFER_STEP = 0.01


@dataclass(frozen=True)
class Constraints:
    """What every layout returned must meet.

    Parameters
    ----------
    min_separation : float
        Least chord between any two cameras [mm], for their housings. 0 lets cameras share a place, which counts
        two views and triangulates nothing.
    min_baseline : float
        Least chord between some two of the cameras that reconstruct a point [mm].
    min_angle : float
        The same as an angle between the two rays at the focus [rad]; the stricter of the two counts.
    fixed : tuple of float
        Ring angles of cameras that stay where they are [rad].
    forbidden : tuple of (float, float)
        Arcs without cameras: each from its first angle counter-clockwise to its second [rad].

    Raises
    ------
    PlacementError
        If a number is negative or not finite.

    Examples
    --------
    >>> float(np.degrees(Constraints(min_separation=10.0).minimum_gap(exact.Ring(diameter=20.0))).round(9))
    60.0
    """

    min_separation: float = 5.0
    min_baseline: float = 0.0
    min_angle: float = 0.0
    fixed: tuple[float, ...] = ()
    forbidden: tuple[tuple[float, float], ...] = ()

    def __post_init__(self):
        for name, unit in (("min_separation", "mm"), ("min_baseline", "mm"), ("min_angle", "rad")):
            value = getattr(self, name)
            # Written so that nan is refused, and a whole number that no float can hold.
            if not (isinstance(value, int | float | np.number) and 0 <= value <= sys.float_info.max):
                raise PlacementError(f"{name} is {value!r}; it must be a number, at least 0 [{unit}]")
        try:
            fixed = tuple(float(angle) for angle in self.fixed)
            forbidden = tuple((float(start), float(end)) for start, end in self.forbidden)
        except (TypeError, ValueError, OverflowError) as error:
            raise PlacementError(
                "fixed must be a row of ring angles and forbidden a row of pairs of ring angles [rad]; got "
                f"fixed={self.fixed!r}, forbidden={self.forbidden!r}"
            ) from error
        if not np.isfinite(np.array(fixed + tuple(np.ravel(forbidden)))).all():
            raise PlacementError("fixed and forbidden ring angles must be finite [rad]")
        largest = max(map(abs, (*fixed, *(angle for arc in forbidden for angle in arc))), default=0.0)
        if largest > LARGEST_ANGLE:
            raise PlacementError(
                f"a fixed or forbidden ring angle is {largest:g} rad; angles must be at most {LARGEST_ANGLE:g} rad to "
                "and fro"
            )
        object.__setattr__(self, "fixed", fixed)
        object.__setattr__(self, "forbidden", forbidden)

    def minimum_gap(self, ring: exact.Ring) -> float:
        """Least angle between neighbours on the ring [rad]: a chord c spans 2 asin(c / d).

        Raises
        ------
        PlacementError
            If no two points of the ring are `min_separation` apart.
        """
        if self.min_separation > ring.diameter:
            raise PlacementError(
                f"a separation of {self.min_separation:g} mm needs a ring of at least as much; this one has "
                f"{ring.diameter:g} mm and takes 1 camera"
            )
        return float(2 * np.arcsin(self.min_separation / ring.diameter))

    def baseline(self, ring: exact.Ring) -> float:
        """Least baseline [mm]: the stricter of `min_baseline` and `min_angle` as seen from the focus.

        Raises
        ------
        PlacementError
            If no two points of the ring are that far apart.
        """
        distance = np.hypot(ring.working_distance, ring.diameter / 2)
        if self.min_angle > np.pi:
            raise PlacementError(f"min_angle is {self.min_angle:g} rad; two rays span at most pi")
        baseline = max(float(self.min_baseline), float(2 * distance * np.sin(self.min_angle / 2)))
        if baseline > ring.diameter:
            widest = 2 * np.arcsin(ring.diameter / 2 / distance)
            raise PlacementError(
                f"no two cameras are {baseline:.4g} mm apart on a ring of {ring.diameter:g} mm; ask for a baseline "
                f"of at most {ring.diameter:g} mm or an angle of at most {offered(np.degrees(widest)):g} degrees"
            )
        return baseline

    def violations(self, ring: exact.Ring, angles) -> list[str]:
        """Say in words what a layout breaks; empty for one that meets everything.

        Parameters
        ----------
        ring : exact.Ring
            The ring.
        angles : (M,) array_like
            Ring angles [rad].

        Examples
        --------
        >>> Constraints(fixed=(0.0,), forbidden=((1.0, 2.0),)).violations(exact.Ring(), [0.0, 1.5, 3.0])
        ['camera at 85.9 degrees is in the forbidden arc from 57.3 to 114.6 degrees']
        """
        theta = np.asarray(angles, dtype=np.float64)
        found = []
        separations = ring.separations(theta) + np.where(np.eye(len(theta)), np.inf, 0.0)
        if len(theta) > 1 and separations.min() < self.min_separation - LENGTH_TOLERANCE:
            found.append(f"two cameras are {separations.min():.6g} mm apart, less than {self.min_separation:g} mm")
        tolerance = LENGTH_TOLERANCE / ring.diameter
        for angle in self.fixed:
            if np.abs(np.sin((theta - angle) / 2)).min() > tolerance:
                found.append(f"no camera at the fixed angle of {np.degrees(angle):.1f} degrees")
        for start, end in self.forbidden:
            width, inside = np.mod(end - start, 2 * np.pi), np.mod(theta - start, 2 * np.pi)
            for angle in theta[(inside > tolerance) & (inside < width - tolerance)]:
                found.append(
                    f"camera at {np.degrees(angle):.1f} degrees is in the forbidden arc from "
                    f"{np.degrees(start):.1f} to {np.degrees(end):.1f} degrees"
                )
        return found


def offered(greatest: float) -> float:
    """What may be asked for [mm, degrees], where `greatest` is feasible and no more is.

    Examples
    --------
    >>> offered(6.3699)
    6.36
    """
    return round(OFFER_STEP * math.floor(greatest / OFFER_STEP), 2)


def demanded(demand: exact.Demand, constraints: Constraints, ring: exact.Ring, n_cameras: int | None = None):
    """The demand with the baseline of the constraints, the stricter of both, if it can be met on the ring.

    Parameters
    ----------
    demand : exact.Demand
    constraints : Constraints
    ring : exact.Ring
    n_cameras : int, optional
        How many cameras there will be.

    Returns
    -------
    exact.Demand

    Raises
    ------
    PlacementError
        If no two cameras of the ring are that far apart, or that many cameras can never meet it.

    Examples
    --------
    >>> demanded(exact.Demand(), Constraints(min_baseline=8.0), exact.Ring(), n_cameras=4).words
    'seen by at least 2 cameras, two of them at least 8 mm apart'
    """
    whole = replace(demand, min_baseline=max(demand.min_baseline, constraints.baseline(ring)))
    if whole.baseline > ring.diameter:
        raise PlacementError(
            f"no two cameras are {whole.baseline:.4g} mm apart on a ring of {ring.diameter:g} mm; ask for a baseline "
            f"of at most {ring.diameter:g} mm"
        )
    if n_cameras is not None:
        with refusing():
            whole.refuse_fewer(n_cameras)
        if n_cameras == 1 and whole.baseline > 0:
            raise PlacementError("one camera has no baseline; ask for at least 2 cameras")
    return whole


def on_ring(demand: exact.Demand, ring: exact.Ring) -> exact.Demand:
    """The demand with depth along the axis of the ring, unless it says along what.

    Examples
    --------
    >>> on_ring(exact.Demand(), exact.Ring(axis=(0, 0, 2))).depth_axis
    (0.0, 0.0, 2.0)
    """
    return demand if demand.depth_axis is not None else replace(demand, depth_axis=ring.axis)


def checked_seed(seed: int) -> int:
    """Return `seed` if it can seed a generator of random numbers.

    Raises
    ------
    PlacementError
        If it is not a whole number, or negative.
    """
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise PlacementError(f"seed is {seed!r}; it must be a whole number, at least 0")
    return int(seed)
