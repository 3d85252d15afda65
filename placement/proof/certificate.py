"""How far a layout is from the best possible: upper bounds that no layout of the request exceeds.

Two bounds, both on the samples and their ring profiles:

- *grid*: cameras only at multiples of the step. Solved to the end, so its layout is the best there is on the grid.
- *any angle*: a point counts as seen from a cell between two neighbouring grid angles if it is seen from anywhere in
  it, and cells exclude each other only if they hold no two angles that are far enough apart. Choosing cells is then
  at least as good as any layout. Smaller cells give a tighter bound; they are halved while that is quick.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

import exact
from exact.demand import SAME_LENGTH
from placement.layouts.arcs import TURN, LayoutSpace
from placement.layouts.constraints import GAP_MARGIN
from placement.proof.branching import branch_and_bound
from placement.proof.enumeration import is_quick
from placement.proof.grid_program import GridProgram, GridSolution
from placement.proof.halving import halved
from placement.proof.solver import solve
from placement.proof.surface_bound import SurfaceBound
from placement.samples.profiles import RingProfiles
from placement.samples.sampled_coverage import SampledCoverage
from placement.settings import Settings

# The grid program is solved to this relative gap: what "proven" means.
PROOF_TOLERANCE = 0.002
# The same for the program over cells, whose solver adds this much to the bound at most.
CELL_TOLERANCE = 0.001
# How much a bound by single cells may be above what is known to be possible: half of what samples err by.
CLOSE = 0.0005
# Angles that differ by less than this many steps are the same.
STEP_TOLERANCE = 1e-6
# Cells are halved at most this often: to three times the width to which the ends of arcs of visibility are known. Where
# linear programs are solved over them, so often.
MOST_HALVINGS, MOST_TREE_HALVINGS = 4, 2
# Random layouts that are moved onto the grid, beside those that are known, to find a good one there.
GRID_STARTS = 8


@dataclass(frozen=True)
class Certificate:
    """Upper bounds for any layout of a request, as fractions of the ring maximum of the samples.

    Of several sites it is the mean fraction or that of the worst site, as was asked for.

    Attributes
    ----------
    bound_fraction : float
        No layout whatever reconstructs more of the samples.
    gap : float or None
        `bound_fraction` less `layout_fraction`.
    proven : bool
        Whether the grid program was solved to 0.2 %.
    seconds : float
        Time taken [s].
    grid_bound_fraction : float
        No layout on the grid reconstructs more of the samples.
    grid_fraction : float or None
        What the best layout found on the grid reconstructs; None if none was found.
    grid_angles : tuple of float or None
        That layout [rad].
    grid_gap : float or None
        `grid_bound_fraction` less `layout_fraction`; below 0 if the layout beats every layout on the grid.
    layout_fraction : float or None
        What the layout in question reconstructs of the samples.
    step, cell : float
        Step of the grid and width of the smallest cells [rad].
    method : str
        How the grid program was solved.
    n_samples, n_profiles : int
        Samples that some camera sees, and their distinct profiles on the grid.
    sampling_error : float
        Standard error of a sampled fraction, measured on parts of the samples.
    ignores_error : bool
        Whether a bound on the predicted error was asked for, of which the bounds know only the baseline that it
        implies: they hold, but may be loose.
    ignores_disparity : bool
        Whether a bound on the disparity gradient was asked for, which the bounds leave out: they hold, but are loose.
    of : str
        What the fractions are fractions of, in words.
    surface : SurfaceBound or None
        What is proven on the surface itself, for layouts on the grid; None if that was not asked for.
    """

    bound_fraction: float
    gap: float | None
    proven: bool
    seconds: float = field(compare=False)
    grid_bound_fraction: float
    grid_fraction: float | None
    grid_angles: tuple[float, ...] | None
    grid_gap: float | None
    layout_fraction: float | None
    step: float
    cell: float
    method: str
    n_samples: int
    n_profiles: int
    sampling_error: float
    ignores_error: bool
    ignores_disparity: bool = False
    of: str = "the ring maximum"
    surface: SurfaceBound | None = None

    @property
    def ignores_baseline(self) -> bool:
        """False: the bounds know the baseline. Kept for programs that ask."""
        return False

    @property
    def statement(self) -> str:
        """What is proven, and what is not, in words."""
        step, cell = np.degrees(self.step), np.degrees(self.cell)
        words = [] if self.surface is None else self.surface.words(self.of, f"{step:g}")
        on_grid = (
            f"no layout with cameras at multiples of {step:g} degrees reconstructs more than "
            f"{self.grid_bound_fraction:.2%} of {self.of}, and "
        )
        words.append(
            f"On {self.n_samples} sample points {on_grid if self.surface is None else ''}no layout at any angles "
            f"reconstructs more than {self.bound_fraction:.2%} ({self.method}, cells of {cell:g} degrees)."
        )
        if self.grid_fraction is None:
            words.append("No layout on the grid meets the constraints, or none was found in time.")
        elif not (self.proven or self.surface is not None):
            words.append(
                f"Time ran out: the best layout known on the grid has {self.grid_fraction:.2%}, so the grid's bound "
                "is not shown to be reached."
            )
        if self.layout_fraction is not None:
            exactly = None if self.surface is None else self.surface.layout_fraction
            exactly = "" if exactly is None else f"{exactly:.2%} of the surface and "
            words.append(f"The layout proposed reconstructs {exactly}{self.layout_fraction:.2%} of the samples.")
        words.append(
            f"Not proven: anything between the samples (standard error of a fraction {self.sampling_error:.2%}), "
            "arcs of visibility narrower than the step at which profiles were traced, and the ends of the others more "
            "finely than they were bisected."
        )
        if self.ignores_error:
            words.append(
                "Of the bound on the error these bounds know only the baseline that it implies; they hold but may be "
                "loose."
            )
        if self.ignores_disparity:
            words.append("All bounds leave out the one on the disparity gradient; they hold but are loose.")
        return " ".join(words)


def certify_samples(
    profiles: RingProfiles,
    space: LayoutSpace,
    demand: exact.Demand,
    settings: Settings,
    of: str = "the ring maximum",
    layouts: Sequence[Float[np.ndarray, " M"]] = (),
) -> Certificate:
    """Bound what any layout of `space` can reconstruct of samples whose weights are shares of the ring maximum.

    Good `layouts` of (M,) ring angles [rad], moved onto the grid, spare the program the search for one.
    """
    begun = time.perf_counter()
    end = begun + settings.certificate_seconds
    n_grid = grid_places(settings)

    program = grid_of(profiles, space, demand, n_grid)
    # Half of the time for the grid; the bound for any angle needs the rest.
    known = known_on_grid(profiles, space, demand, n_grid, layouts)
    grid = solve(program, settings.certificate_seconds / 2, PROOF_TOLERANCE, known)
    angles = _angles(grid, space, n_grid)
    coverage = SampledCoverage(profiles, demand, space.ring, settings.n_grid)
    some = [np.array(layout) for layout in (*layouts, angles) if layout is not None and space.allows(layout)]
    least = max((coverage.fraction(coverage.improve(space, layout)) for layout in some), default=0.0)
    bound, n_cells = _any_angle(profiles, space, demand, n_grid, least, end)
    # The program takes of a bound on the error only what it implies, the samples all of it.
    grid_fraction = None if angles is None else coverage.fraction(angles)
    # A layout on the grid is a layout; what one reconstructs may be summed in another order.
    grid_bound = max(min(grid.bound, bound), grid_fraction or 0.0)
    return Certificate(
        bound_fraction=max(bound, grid_fraction or 0.0),
        gap=None,
        proven=grid_bound - (grid_fraction or 0.0) <= 1.01 * PROOF_TOLERANCE,
        seconds=time.perf_counter() - begun,
        grid_bound_fraction=grid_bound,
        grid_fraction=grid_fraction,
        grid_angles=angles,
        grid_gap=None,
        layout_fraction=None,
        step=TURN / n_grid,
        cell=TURN / n_cells,
        method=grid.method,
        n_samples=len(profiles.weights),
        n_profiles=len(program.merged().weights),
        sampling_error=_sampling_error(profiles, angles, demand, space.ring),
        ignores_error=demand.max_error is not None,
        ignores_disparity=demand.max_disparity_gradient is not None,
        of=of,
    )


def _any_angle(
    profiles: RingProfiles, space: LayoutSpace, demand: exact.Demand, n_grid: int, least: float, end: float
) -> tuple[float, int]:
    """What no layout is worth more than, `least` if some layout is worth that, and how many cells show it."""
    bound, n_cells = float(profiles.sums(np.asarray(profiles.visible.any(axis=0))).min()), n_grid
    cells = cells_of(profiles, space, demand, n_grid * 2**MOST_HALVINGS)
    if not cells.is_spread and cells.n_free > 0:
        found = halved(cells, None, least * (1 + CLOSE), end)
        if found is not None:
            bound, n_cells = min(found.bound, bound), len(cells.seen)
            if found.finished:
                return bound, n_cells
    for halving in range(MOST_TREE_HALVINGS + 1):
        cells = cells_of(profiles, space, demand, n_grid * 2**halving)
        # What is not enumerated is bounded step by step: more closely by fine cells, of which coarse ones would only
        # take the time.
        if halving == 0 and not is_quick(cells):
            continue
        left = max(end - time.perf_counter(), 1.0)
        found = (solve if cells.is_spread else branch_and_bound)(cells.merged(), left, CELL_TOLERANCE)
        if found.bound < bound:
            bound, n_cells = found.bound, len(cells.seen)
        if not found.finished or time.perf_counter() > end:
            break
    return bound, n_cells


def measure(
    certificate: Certificate, profiles: RingProfiles, layout, demand: exact.Demand, ring: exact.Ring
) -> Certificate:
    """Return the certificate with the gaps of `layout`, (M,) ring angles [rad], to its bounds."""
    fraction = SampledCoverage(profiles, demand, ring).fraction(layout)
    return replace(
        certificate,
        layout_fraction=fraction,
        gap=certificate.bound_fraction - fraction,
        grid_gap=certificate.grid_bound_fraction - fraction,
        sampling_error=_sampling_error(profiles, layout, demand, ring),
    )


def at_most(certificate: Certificate, more: Certificate) -> Certificate:
    """The certificate, which knows that no layout reconstructs more than any with one camera more, if that has room."""
    if more.bound_fraction >= certificate.bound_fraction:
        return certificate
    gap = None if certificate.layout_fraction is None else more.bound_fraction - certificate.layout_fraction
    grid_bound = min(certificate.grid_bound_fraction, more.bound_fraction)
    grid_gap = None if certificate.layout_fraction is None else grid_bound - certificate.layout_fraction
    return replace(
        certificate, bound_fraction=more.bound_fraction, gap=gap, cell=more.cell, grid_bound_fraction=grid_bound,
        grid_gap=grid_gap,
    )  # fmt: skip


def grid_places(settings: Settings) -> int:
    """How many grid angles the settings ask for."""
    return max(4, round(TURN / settings.certificate_step))


def known_on_grid(
    profiles: RingProfiles,
    space: LayoutSpace,
    demand: exact.Demand,
    n_grid: int,
    layouts: Sequence[Float[np.ndarray, " M"]],
) -> tuple[int, ...] | None:
    """Places of the free cameras of a good layout on the grid; None if none is found that is allowed."""
    if space.n_free == 0:
        return None
    coverage, step = SampledCoverage(profiles, demand, space.ring, n_grid), TURN / n_grid
    rng = np.random.default_rng(0)
    best, places = -1.0, None
    for layout in (*layouts, *(space.random(rng) for _ in range(GRID_STARTS))):
        free = space.free_cameras(layout)
        snapped = np.array(layout, dtype=np.float64)
        snapped[free] = step * np.round(snapped[free] / step)
        if not space.allows(snapped):
            continue
        snapped = coverage.improve(space, snapped)
        if coverage.fraction(snapped) > best:
            index = np.round(snapped[space.free_cameras(snapped)] / step).astype(int) % n_grid
            best, places = coverage.fraction(snapped), tuple(np.sort(index).tolist())
    return places


def grid_of(profiles: RingProfiles, space: LayoutSpace, demand: exact.Demand, n_grid: int) -> GridProgram:
    """Layouts with the free cameras at multiples of 2 pi / n_grid, as a program."""
    fixed = np.array(space.constraints.fixed)
    possible, apart = _apart(profiles, space, demand)
    rules = grid_rules(space, n_grid, apart)
    return GridProgram(
        profiles.at(TURN / n_grid * np.arange(n_grid)) & possible, profiles.weights, space.n_free, demand.threshold,
        rules.window, rules.allowed, profiles.site, rules.apart, _seen_by_fixed(profiles, fixed) & possible,
        rules.fixed_at, profiles.n_sites,
    )  # fmt: skip


class GridRules(NamedTuple):
    """What a grid program says of places, whatever they see: fields as those of `GridProgram`."""

    window: int
    allowed: Bool[np.ndarray, " K"]
    apart: Float[np.ndarray, " P"]
    fixed_at: Float[np.ndarray, " F"]


def grid_rules(space: LayoutSpace, n_grid: int, apart: Float[np.ndarray, " P"]) -> GridRules:
    """Which places layouts of `space` may take together; (P,) `apart` is how far two must be for each point [rad]."""
    step = TURN / n_grid
    return GridRules(
        int(np.ceil(space.minimum_gap / step - STEP_TOLERANCE)),
        space.allowed(step * np.arange(n_grid), np.array(space.constraints.fixed), slack=2 * GAP_MARGIN),
        np.maximum(apart / step - STEP_TOLERANCE, 0.0),
        np.array(space.constraints.fixed) / step,
    )


def cells_of(profiles: RingProfiles, space: LayoutSpace, demand: exact.Demand, n_cells: int) -> GridProgram:
    """Choose the cells [2 pi k / n, 2 pi (k + 1) / n] that the free cameras lie in: no layout is left out."""
    step = TURN / n_cells
    # Every arc of visibility holds a profile angle: one that meets a cell holds an end of it, or lies inside with its
    # profile angle.
    nodes = TURN * np.arange(profiles.n_angles) / profiles.n_angles
    ends = profiles.at(step * np.arange(n_cells))
    seen = ends | np.roll(ends, -1, axis=0)
    np.logical_or.at(seen, np.floor(nodes / step + STEP_TOLERANCE).astype(int) % n_cells, profiles.visible)
    # Angles of two cells w apart differ by up to (w + 1) steps, less when that is no longer the short way around.
    window = max(0, int(np.ceil(space.minimum_gap / step - 1 - STEP_TOLERANCE)))
    fixed = np.array(space.constraints.fixed)
    possible, apart = _apart(profiles, space, demand)
    return GridProgram(
        seen & possible, profiles.weights, space.n_free, demand.threshold, window, _open_cells(space, n_cells),
        profiles.site, np.maximum(apart / step - 1 - STEP_TOLERANCE, 0.0), _seen_by_fixed(profiles, fixed) & possible,
        np.floor(fixed / step), profiles.n_sites, slack=1,
    )  # fmt: skip


def _seen_by_fixed(profiles: RingProfiles, fixed: Float[np.ndarray, " F"]) -> Bool[np.ndarray, "F N"]:
    return profiles.at(fixed) if len(fixed) else np.zeros((0, len(profiles.weights)), dtype=bool)


def _apart(
    profiles: RingProfiles, space: LayoutSpace, demand: exact.Demand
) -> tuple[Bool[np.ndarray, " N"], Float[np.ndarray, " N"]]:
    """(N,) bool: can the demand be met at all, and how far apart two cameras must be for it around the ring [rad].

    M cameras in an arc of chord b have a spread of at most M b² / 4, the greatest with half of them at either end, and
    (M² - 1) b² / (4 M) if M is odd. So an error asks for a baseline too, each point for its own.
    """
    n_cameras = space.n_cameras
    chord = np.full(len(profiles.weights), demand.baseline * (1 - SAME_LENGTH))
    if demand.max_error is not None:
        spread = profiles.noise / demand.max_error**2
        implied = np.sqrt(4 * n_cameras * spread / max(n_cameras**2 - n_cameras % 2, 1))
        chord = np.maximum(chord, implied * (1 - SAME_LENGTH))
    return chord <= space.ring.diameter, arc_of(chord, space.ring)


def arc_of(chord: Float[np.ndarray, " N"], ring: exact.Ring) -> Float[np.ndarray, " N"]:
    """How far apart around the ring [rad] cameras are whose distance is (N,) `chord`."""
    return 2 * np.arcsin(np.minimum(chord / ring.diameter, 1.0))


def _open_cells(space: LayoutSpace, n_cells: int) -> Bool[np.ndarray, " {n_cells}"]:
    """(n_cells,) bool: cells that hold an angle which is allowed; those in a single blocked arc hold none."""
    step = TURN / n_cells
    start = step * np.arange(n_cells)
    blocked = [(angle - space.minimum_gap, 2 * space.minimum_gap) for angle in space.constraints.fixed]
    blocked += [(first, np.mod(last - first, TURN)) for first, last in space.constraints.forbidden]
    is_open = np.ones(n_cells, dtype=bool)
    for first, width in blocked:
        inside = np.mod(start - first, TURN)
        # Strictly: an allowed layout may sit on the very end of a blocked arc.
        is_open &= ~((inside > 4 * GAP_MARGIN) & (inside + step < width - 4 * GAP_MARGIN))
    return is_open


def _angles(grid: GridSolution, space: LayoutSpace, n_grid: int) -> tuple[float, ...] | None:
    if grid.places is None:
        return None
    return (*(TURN * np.array(grid.places, dtype=float) / n_grid).tolist(), *space.constraints.fixed)


def _sampling_error(profiles: RingProfiles, layout, demand: exact.Demand, ring: exact.Ring) -> float:
    """Standard error of a layout's fraction, from the scatter among interleaved parts of the samples."""
    if layout is None:
        return float("nan")
    covered = SampledCoverage(profiles, demand, ring).covered(layout)
    binding = profiles.site == int(profiles.sums(covered).argmin())
    inside = binding & (profiles.visible.sum(axis=0) >= demand.threshold)
    n_in, got = profiles.parts @ inside, profiles.parts @ (inside & covered)
    fractions = got / np.where(n_in > 0, n_in, 1.0)
    return float(fractions.std(ddof=1) / np.sqrt(len(fractions)))
