"""The ring itself as a variable: diameter and working distance together with the cameras on it, by the exact area."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize

import exact
from exact.requests import checked_demand, demand_keywords, refuse_unknown, shows
from placement.errors import PlacementError, refusing
from placement.layouts.constraints import Constraints, demanded, on_ring
from placement.search.scoring import squared_errors
from placement.sites import Objective, Sites, Surfaces, checked_sites, scene_keywords

ASKED = {**scene_keywords(), **demand_keywords(), "demand": None}
# Separations are kept with so much to spare [mm], and errors with this part of them, since a minimiser meets a bound
# only to rounding.
SPARE_SEPARATION, SPARE_ERROR = 1e-6, 1e-5
# Steps of the minimiser at most, with a derivative and without, and the relative gain below which it stops.
MOST_STEPS, MOST_STEPS_OF_DIFFERENCES, WORTHWHILE = 40, 15, 1e-7
# Of points on the way that are not quite as accurate as the start, so many are brought nearer until they are.
N_KEPT = 5
# Cameras in one place have no spread [mm²], and no error.
LEAST_SPREAD = 1e-9
# Step of differences where the area has no derivative, in parts of lengths, and in radians.
STEP = 1e-4


@dataclass(frozen=True)
class RefinedRing:
    """A ring and its cameras, moved to where they reconstruct more.

    Attributes
    ----------
    ring : exact.Ring
    angles : (M,) tuple of float
        Ring angles of the cameras [rad].
    rolls : (M,) tuple of float or None
        Of the cameras [rad], as `exact.Ring.cameras` takes them; None where they are the ring's.
    areas : (S,) tuple of float
        Exact reconstructable area of each site [mm²].
    fraction : float
        Of all that counts, seen or not: area over counted area, over all sites as their objective says.
    error_rms : float
        Root mean square of the predicted errors [mm]; infinite for one camera.
    n_evaluations : int
        Rings and layouts whose exact area was asked for.
    """

    ring: exact.Ring
    angles: tuple[float, ...]
    rolls: tuple[float, ...] | None
    areas: tuple[float, ...]
    fraction: float
    error_rms: float
    n_evaluations: int

    @property
    def area(self) -> float:
        """Exact reconstructable area [mm²]; of several sites the sum."""
        return float(sum(self.areas))

    @property
    def smallest_separation(self) -> float:
        """Least chord between two cameras [mm]; infinite for one camera."""
        separations = self.ring.separations(self.angles)
        return float(np.min(separations[~np.eye(len(separations), dtype=bool)], initial=np.inf))


@shows(ASKED)
def refine_ring(
    mesh: Surfaces,
    ring: exact.Ring,
    angles,
    *,
    diameter: tuple[float, float],
    working_distance: tuple[float, float],
    rolls=None,
    constraints: Constraints | None = None,
    site_weights=None,
    objective: Objective = "mean",
    **asked: Any,
) -> RefinedRing:
    """Change diameter, working distance and layout together so that more is reconstructed, and no less accurately.

    The exact area is maximised by its exact derivative (`exact.gradient`), or by differences of it where a bound on the
    error leaves none. What is found is a local maximum; start from the best of several rings. The predicted error of a
    point at the focus that all cameras see does not grow, or the area would be bought with accuracy.

    Parameters
    ----------
    mesh, constraints, site_weights, objective
        As for `optimise`.
    ring : exact.Ring
        To start from; its field of view at the focus stays.
    angles : (M,) array_like
        Ring angles of the layout to start from [rad].
    diameter, working_distance : (float, float)
        Least and greatest [mm].
    rolls : (M,) array_like, optional
        Of the layout to start from [rad], as `exact.Ring.cameras` takes them; they are variables too.
    **asked
        What counts, and on what, as for `optimise`.

    Returns
    -------
    RefinedRing
        With at least the area of the start.

    Raises
    ------
    PlacementError
        If the start is not within the bounds, or breaks the constraints.

    Examples
    --------
    >>> import trimesh
    >>> step = trimesh.util.concatenate([trimesh.creation.box((30, 30, 1)), trimesh.creation.box((1, 8, 30))])
    >>> ring = exact.Ring()
    >>> found = refine_ring(step, ring, [0.5, 2.0, 4.0], diameter=(20, 40), working_distance=(300, 500))
    >>> start = exact.evaluate(step, ring.cameras([0.5, 2.0, 4.0])).area
    >>> found.area >= start, 20 <= found.ring.diameter <= 40, 300 <= found.ring.working_distance <= 500
    (True, True, True)
    """
    refuse_unknown(asked, {*scene_keywords(), *demand_keywords(), "demand"})
    with refusing():
        demand = checked_demand(asked)
    scenes = {name: asked.get(name) for name in scene_keywords()}
    sites = checked_sites(mesh, site_weights=site_weights, objective=objective, **scenes)
    theta = np.array(angles, dtype=np.float64)
    asked_of = _Asked(sites, ring, demand, Constraints() if constraints is None else constraints, theta, rolls)
    bounds = {"ring diameter": (ring.diameter, diameter), "working distance": (ring.working_distance, working_distance)}
    for name, (start, (least, most)) in bounds.items():
        if not least <= start <= most:
            raise PlacementError(f"{name} is {start:g} mm to start with; it must be from {least:g} to {most:g} mm")
    if broken := asked_of.constraints.violations(ring, theta):
        raise PlacementError(f"the layout to start from does not meet the constraints: {broken[0]}; start elsewhere")
    return asked_of.refined(diameter, working_distance)


def counted_area(scene: exact.Scene) -> float:
    """Area [mm²] of all that counts, seen or not; weighted if faces are.

    Examples
    --------
    >>> import trimesh
    >>> counted_area(exact.Scene(trimesh.creation.box((2, 2, 2))))
    24.0
    """
    return float(scene.worth(scene.of_mesh(scene.surface.areas * scene.counted)))


class _Asked:
    """The start and what is asked; a point x is diameter and distance, in parts of those of the start, and angles."""

    def __init__(self, sites: Sites, ring: exact.Ring, demand: exact.Demand, constraints: Constraints, theta, rolls):
        self.sites, self.ring, self.constraints, self.theta = sites, ring, constraints, theta
        self._demand = on_ring(demand, ring)
        self.rolls = None if rolls is None else np.array(rolls, dtype=np.float64)
        away = np.abs(np.sin((theta[:, None] - np.array(constraints.fixed)[None, :]) / 2))
        self.free = np.flatnonzero(~(away < 1e-9).any(axis=1))
        self.counted = np.array([counted_area(site.scene) for site in sites.members])
        self.start = np.concatenate([[1.0, 1.0], theta[self.free], [] if self.rolls is None else self.rolls])
        self.n_evaluations, self.best = 0, (-np.inf, self.start)
        # Better ones that are less accurate than the start, by rounding or more.
        self.tried: list[tuple[float, np.ndarray]] = []

    def at(self, x: Float[np.ndarray, " P"]) -> tuple[exact.Ring, np.ndarray, np.ndarray | None]:
        """Ring, ring angles and rolls of a point."""
        theta, n = self.theta.copy(), 2 + len(self.free)
        theta[self.free] = x[2:n]
        ring = replace(
            self.ring, diameter=float(x[0] * self.ring.diameter),
            working_distance=float(x[1] * self.ring.working_distance),
        )  # fmt: skip
        return ring, theta, None if self.rolls is None else x[n:]

    def demand_on(self, ring: exact.Ring, n_cameras: int) -> exact.Demand:
        return demanded(self._demand, self.constraints, ring, n_cameras)

    def refined(self, diameter: tuple[float, float], working_distance: tuple[float, float]) -> RefinedRing:
        lengths = zip((diameter, working_distance), (self.ring.diameter, self.ring.working_distance), strict=True)
        bounds = [(least / start, most / start) for (least, most), start in lengths]
        bounds += [self._open_arc(angle) for angle in self.theta[self.free]]
        bounds += [(None, None)] * (len(self.start) - len(bounds))
        has_derivative = self._demand.has_derivative
        kept = [{"type": "ineq", "fun": self._separations}, {"type": "ineq", "fun": self._error_left}]
        scale = -1 / max(self._value(self.start), np.finfo(float).tiny)

        def loss(x):
            if not has_derivative:
                return scale * self._value(x)
            value, derivative = self._value_and_derivative(x)
            return scale * value, scale * derivative

        options = {"maxiter": MOST_STEPS if has_derivative else MOST_STEPS_OF_DIFFERENCES, "ftol": WORTHWHILE}
        if not has_derivative:
            options["finite_diff_rel_step"] = STEP
        minimize(
            loss, self.start, jac=has_derivative or "2-point", bounds=bounds, constraints=kept, method="SLSQP",
            options=options,
        )  # fmt: skip
        for _, x in sorted(self.tried, key=lambda one: -one[0])[:N_KEPT]:
            nearer = self._as_accurate(x, working_distance[0] / self.ring.working_distance)
            if nearer is not None:
                self._value(nearer)
        ring, theta, rolls = self.at(self.best[1])
        demand, cameras = self.demand_on(ring, len(theta)), ring.cameras(theta, rolls)
        areas = tuple(exact.evaluate(site.scene, cameras, demand=demand).area for site in self.sites.members)
        squares, weights = (
            np.sum([squared_errors(site.scene, cameras, demand) for site in self.sites.members], axis=0)
            if len(theta) > 1 else (np.inf, 1.0)
        )  # fmt: skip
        return RefinedRing(
            ring, tuple(np.mod(theta, 2 * np.pi).tolist()), None if rolls is None else tuple(rolls.tolist()), areas,
            self.sites.combined(np.array(areas) / self.counted),
            float(np.sqrt(squares / weights)) if weights > 0 else np.inf, self.n_evaluations,
        )  # fmt: skip

    def _value(self, x: Float[np.ndarray, " P"]) -> float:
        ring, theta, rolls = self.at(x)
        demand, cameras = self.demand_on(ring, len(theta)), ring.cameras(theta, rolls)
        found = [exact.evaluate(site.scene, cameras, demand=demand).area for site in self.sites.members]
        return self._noted(x, ring, theta, found)

    def _value_and_derivative(self, x: Float[np.ndarray, " P"]) -> tuple[float, Float[np.ndarray, " P"]]:
        ring, theta, rolls = self.at(x)
        demand, cameras = self.demand_on(ring, len(theta)), ring.cameras(theta, rolls)
        found = [exact.gradient(site.scene, cameras, demand=demand) for site in self.sites.members]
        areas = np.array([one.area for one in found])
        shares = self.sites.shares / self.counted
        if self.sites.objective == "worst":
            shares = (np.arange(len(areas)) == np.argmin(areas / self.counted)) / self.counted
        total = np.zeros(len(x))
        for share, one in zip(shares, found, strict=True):
            by = one.on_ring(ring)
            parts = [[by.radius.sum() * self.ring.diameter / 2, by.height.sum() * self.ring.working_distance]]
            parts += [by.angle[self.free]] + ([] if rolls is None else [by.roll])
            total += share * np.concatenate(parts)
        return self._noted(x, ring, theta, areas), total

    def _noted(self, x, ring: exact.Ring, theta: np.ndarray, areas) -> float:
        """What areas are worth; the best point that keeps everything is remembered."""
        self.n_evaluations += 1
        value = self.sites.combined(np.asarray(areas) / self.counted)
        if value > self.best[0] and not self.constraints.violations(ring, theta):
            if len(theta) == 1 or self._relative_error(x) <= self._relative_error(self.start):
                self.best = (value, x.copy())
            else:
                self.tried.append((value, x.copy()))
        return value

    def _as_accurate(self, x: Float[np.ndarray, " P"], least: float) -> Float[np.ndarray, " P"] | None:
        """The same with the ring so much nearer that it is as accurate as the start; None if that is too near."""
        ring, theta, _ = self.at(x)
        # h² / (r √S) = e has the solution 2 h² = q² + q √(q² + d²) with q = e √S.
        most = (1 - SPARE_ERROR) * self._relative_error(self.start) * np.sqrt(_spread(ring, theta))
        height = np.sqrt((most**2 + most * np.hypot(most, ring.diameter)) / 2)
        share = float(height / self.ring.working_distance)
        return None if share < least else np.concatenate([[x[0], min(x[1], share)], x[2:]])

    def _separations(self, x: Float[np.ndarray, " P"]) -> Float[np.ndarray, " C"]:
        """What is left of separations beyond the least one, and of the diameter beyond the baseline [mm]."""
        ring, theta, _ = self.at(x)
        first, second = np.triu_indices(len(theta), k=1)
        left = ring.separations(theta)[first, second] - self.constraints.min_separation - SPARE_SEPARATION
        distance = np.hypot(ring.working_distance, ring.diameter / 2)
        baseline = max(self._demand.min_baseline, self.constraints.min_baseline)
        baseline = max(baseline, 2 * distance * np.sin(self.constraints.min_angle / 2))
        return np.append(left, ring.diameter - baseline)

    def _error_left(self, x: Float[np.ndarray, " P"]) -> float:
        """What is left of the error, at the focus and of all cameras, that the start has; as a part of it.

        It goes with h² / (r √S), for a field of view that stays: see `docs/mathematics.md`.
        """
        return (
            1.0 - SPARE_ERROR - self._relative_error(x) / self._relative_error(self.start)
            if len(self.theta) > 1
            else 1.0
        )

    def _relative_error(self, x: Float[np.ndarray, " P"]) -> float:
        ring, theta, _ = self.at(x)
        distance = np.hypot(ring.working_distance, ring.diameter / 2)
        return float(ring.working_distance**2 / (distance * np.sqrt(_spread(ring, theta))))

    def _open_arc(self, angle: float) -> tuple[float | None, float | None]:
        """Between which forbidden arcs a camera is [rad]."""
        if not self.constraints.forbidden:
            return None, None
        start, end = np.array(self.constraints.forbidden).T
        return float(angle - np.mod(angle - end, 2 * np.pi).min()), float(
            angle + np.mod(start - angle, 2 * np.pi).min()
        )


def _spread(ring: exact.Ring, theta: Float[np.ndarray, " M"]) -> float:
    """Sum of the squared distances of the cameras from their centre [mm²]; above 0."""
    n = len(theta)
    return max((ring.diameter / 2) ** 2 * (n - float(np.abs(np.exp(1j * theta).sum())) ** 2 / n), LEAST_SPREAD)
