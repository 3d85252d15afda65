"""All feasible layouts of a request: which arcs are open, and how many cameras fit where.

With fixed cameras or forbidden arcs the circle is cut open and what is left is a row of arcs. A layout gives each
arc some of the free cameras; for each such assignment the feasible layouts form one connected set, which
`layout.angles_from_arcs` covers. Whether a request can be met at all is decided by going through them.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Float, Int

import exact
from exact.ring import MOST_CAMERAS
from placement.errors import PlacementError
from placement.layouts.constraints import GAP_MARGIN, LENGTH_TOLERANCE, Constraints, offered
from placement.layouts.layout_parameters import Arcs, arcs_from_angles, gaps_from_angles
from placement.layouts.open_arcs import TURN, greatest_separation, most_cameras, open_arcs, packed, widest_pair

# Ways to share the cameras among the arcs that are listed; of more one is drawn where one is needed, so often at most
# until it can be met.
MOST_LISTED, MOST_DRAWS = 10_000, 100


class LayoutSpace:
    """The layouts of `n_cameras` cameras on `ring` that meet `constraints`.

    Parameters
    ----------
    ring : exact.Ring
        The ring.
    n_cameras : int
        Number of cameras M, fixed ones included.
    constraints : Constraints
        What every layout must meet.

    Raises
    ------
    PlacementError
        If no layout meets them; the message says why and what would be feasible.

    Examples
    --------
    >>> space = LayoutSpace(exact.Ring(), 4, Constraints(fixed=(0.0,), forbidden=((1.0, 2.0),)))
    >>> angles = space.random(np.random.default_rng(0))
    >>> space.constraints.violations(space.ring, angles)
    []
    >>> LayoutSpace(exact.Ring(), 12, Constraints(min_separation=10.0))
    Traceback (most recent call last):
    placement.errors.PlacementError: 12 cameras at 10 mm need a ring of at least 38.6 mm; this one takes 9
    """

    def __init__(self, ring: exact.Ring, n_cameras: int, constraints: Constraints):
        if not isinstance(n_cameras, int | np.integer) or isinstance(n_cameras, bool) or n_cameras < 1:
            raise PlacementError(f"number of cameras is {n_cameras!r}; it must be a whole number, at least 1")
        if n_cameras > MOST_CAMERAS:
            raise PlacementError(f"number of cameras is {n_cameras}; it must be at most {MOST_CAMERAS}")
        if len(constraints.fixed) > n_cameras:
            raise PlacementError(
                f"{len(constraints.fixed)} cameras are fixed but the layout has {n_cameras}; ask for at least "
                f"{len(constraints.fixed)}"
            )
        self.ring = ring
        self.n_cameras = int(n_cameras)
        self.n_free = self.n_cameras - len(constraints.fixed)
        self.constraints = constraints
        self.is_whole = not (constraints.fixed or constraints.forbidden)
        self._check_fixed()
        self.minimum_gap = self._checked_gap()
        if not self.is_whole:
            self._open = open_arcs(constraints, self.minimum_gap)
            self._shares = self._feasible_shares()
            if not self._shares:
                raise self._too_many()
        self._check_baseline()

    def _checked_gap(self) -> float:
        """Minimum gap with its margin [rad], where as many gaps fit on the ring."""
        if self.n_cameras == 1:
            return 0.0
        gap, n = self.constraints.minimum_gap(self.ring), self.n_cameras
        left = TURN - n * gap
        if left < -n * GAP_MARGIN:
            separation = self.constraints.min_separation
            takes = int(TURN / gap + GAP_MARGIN) if self.is_whole else most_cameras(self.constraints, gap, n)
            raise PlacementError(
                f"{n} cameras at {separation:g} mm need a ring of at least {separation / np.sin(np.pi / n):.1f} mm; "
                f"this one takes {takes}{self._beside()}"
            )
        return gap + (min(GAP_MARGIN, max(left, 0.0) / n) if gap > 0 else 0.0)

    def _check_fixed(self) -> None:
        fixed = np.array(self.constraints.fixed)
        for start, end in self.constraints.forbidden:
            if abs(end - start) >= TURN:
                raise PlacementError("a forbidden arc covers the whole ring; it leaves no room for a camera")
        if len(fixed):
            wrong = Constraints(self.constraints.min_separation, forbidden=self.constraints.forbidden)
            for reason in wrong.violations(self.ring, fixed):
                raise PlacementError(
                    f"the fixed cameras contradict the constraints: {reason}; move the camera, or ask for less"
                )

    def _check_baseline(self) -> None:
        """Some two cameras must be able to be a baseline apart, or no layout reconstructs anything."""
        baseline = self.constraints.baseline(self.ring)
        widest = self.ring.diameter * np.sin(widest_pair(self.constraints, self.minimum_gap, self.n_cameras) / 2)
        if self.n_cameras > 1 and baseline > widest + LENGTH_TOLERANCE:
            raise PlacementError(
                f"no two of {self.n_cameras} cameras can be {baseline:.4g} mm apart{self._beside()}; ask for a "
                f"baseline of at most {offered(widest):g} mm"
            )

    def _beside(self) -> str:
        """What takes room on the ring, as the end of a sentence."""
        taken = {"fixed one": len(self.constraints.fixed), "forbidden arc": len(self.constraints.forbidden)}
        words = " and ".join(f"{n} {what}{'s' if n > 1 else ''}" for what, n in taken.items() if n)
        return f" beside {words}" if words else ""

    def _too_many(self) -> PlacementError:
        n, separation = self.n_cameras, self.constraints.min_separation
        most = most_cameras(self.constraints, self.minimum_gap, n - 1)
        offer = greatest_separation(self.ring, self.constraints, n)
        return PlacementError(
            f"{n} cameras at {separation:g} mm do not fit{self._beside()}: {most} do"
            + (f", or {n} at {offer:g} mm" if offer > 0 else "")
        )

    def _feasible_shares(self) -> list[tuple[int, ...]]:
        """Ways to share the free cameras among the open arcs: all of them, or one of very many."""
        gap, n_free = self.minimum_gap, self.n_free
        widths = np.diff(self._open)[:, 0]
        room = [min(int(width / gap + GAP_MARGIN) + 1, n_free) if gap else n_free for width in widths]
        self._room, self._ways = room, _ways_to_share(n_free, room)
        if self._ways[0, n_free] <= MOST_LISTED:
            return [counts for counts in _counts(n_free, room) if self._arcs(counts) is not None]
        some = tuple(packed(self.constraints, self.minimum_gap, self.n_free).tolist())
        return [some] if sum(some) == self.n_free and self._arcs(some) is not None else []

    def _arcs(self, counts: tuple[int, ...]) -> Arcs | None:
        """The arc of each free camera where the open arcs hold so many; None if they do not."""
        return _tightened(np.repeat(self._open, counts, axis=0), self.minimum_gap, self.constraints.fixed)

    def _random_arcs(self, rng: np.random.Generator) -> Arcs:
        """Of a way to share the cameras among the open arcs, each as likely as any other."""
        if self._ways[0, self.n_free] > MOST_LISTED:
            for _ in range(MOST_DRAWS):
                arcs = self._arcs(_drawn_share(self._ways, self._room, rng))
                if arcs is not None:
                    return arcs
        arcs = self._arcs(self._shares[rng.integers(len(self._shares))])
        assert arcs is not None  # only such as can be met are kept
        return arcs

    def parameters(self, angles) -> tuple[Float[np.ndarray, " P"], Arcs | None]:
        """Free parameters of a layout that meets the constraints, and the arcs they refer to.

        Parameters
        ----------
        angles : (M,) array_like
            Ring angles [rad], fixed cameras included.

        Raises
        ------
        PlacementError
            If the layout does not meet the constraints.
        """
        theta = np.asarray(angles, dtype=np.float64)
        reasons = self.constraints.violations(self.ring, theta)
        if reasons or len(theta) != self.n_cameras:
            raise PlacementError(f"not a layout of this request: {'; '.join(reasons) or f'{len(theta)} cameras'}")
        if self.is_whole:
            return gaps_from_angles(theta, self.minimum_gap), None
        theta = theta[self.free_cameras(theta)]
        start = self._open[0][0] if len(self._open) else 0.0
        tolerance = 2 * GAP_MARGIN
        theta = np.sort(start + np.mod(theta - start + tolerance, TURN) - tolerance)
        arc = np.array([np.argmin([max(a - t, t - b, 0.0) for a, b in self._open]) for t in theta], dtype=int)
        counts = tuple(np.bincount(arc, minlength=len(self._open)).tolist())
        arcs = self._arcs(counts)
        if arcs is None:
            raise PlacementError("not a layout of this request: it keeps the constraints only within rounding")
        return arcs_from_angles(theta, arcs, self.minimum_gap), arcs

    def random(self, rng: np.random.Generator) -> Float[np.ndarray, " M"]:
        """(M,) ring angles [rad] of a random feasible layout; every feasible layout can come up."""
        if self.is_whole:
            shares = rng.dirichlet(np.ones(self.n_cameras))
            gaps = self.minimum_gap + (TURN - self.n_cameras * self.minimum_gap) * shares
            return rng.uniform(0, TURN) + np.concatenate([[0.0], np.cumsum(gaps[:-1])])
        arcs = self._random_arcs(rng)
        shifted = np.empty(self.n_free)
        for i, share in enumerate(rng.random(self.n_free)):
            least, most = arcs.lower[i], arcs.upper[i]
            if i:
                least, most = max(least, shifted[i - 1]), min(most, shifted[0] + arcs.slack)
            shifted[i] = least + max(most - least, 0.0) * share
        return np.concatenate([shifted + self.minimum_gap * np.arange(self.n_free), arcs.fixed])

    def free_cameras(self, angles) -> Int[np.ndarray, " m"]:
        """Tell the indices of the cameras of a layout of M ring angles [rad] that are not fixed."""
        theta = np.asarray(angles, dtype=np.float64)
        free = np.ones(len(theta), dtype=bool)
        for fixed in self.constraints.fixed:
            distance = np.where(free, np.abs(np.sin((theta - fixed) / 2)), np.inf)
            free[distance.argmin()] = False
        return np.flatnonzero(free)

    def allowed(self, candidates, others, slack: float = 0.0) -> Bool[np.ndarray, " G"]:
        """(G,) bool: may one more camera be at each of the (G,) ring angles beside the others, to `slack` [rad]."""
        candidates = np.asarray(candidates, dtype=np.float64)
        half_gaps = np.abs(np.sin((candidates[:, None] - np.asarray(others)[None, :]) / 2))
        allowed = (half_gaps >= np.sin(max(self.minimum_gap - slack, 0.0) / 2)).all(axis=1)
        for start, end in self.constraints.forbidden:
            inside = np.mod(candidates - start, TURN)
            allowed &= (inside <= 0) | (inside >= np.mod(end - start, TURN))
        return allowed

    @property
    def leaves_room(self) -> bool:
        """Whether one more camera would find a place beside any layout of this space."""
        open_length = TURN if self.is_whole else float(np.diff(self._open, axis=1).sum())
        # Each free camera keeps others off on either side; the fixed ones' sides are no open arcs.
        return open_length > 2 * self.n_free * self.minimum_gap

    def allows(self, angles) -> bool:
        """Whether a layout of M ring angles [rad] meets every constraint."""
        return len(angles) == self.n_cameras and not self.constraints.violations(self.ring, angles)


def _counts(total: int, room: list[int]) -> Iterator[tuple[int, ...]]:
    """Every way to share `total` among bins with so much room."""
    if not room:
        if total == 0:
            yield ()
        return
    others = sum(room[1:])
    for first in range(max(0, total - others), min(total, room[0]) + 1):
        for rest in _counts(total - first, room[1:]):
            yield (first, *rest)


def _ways_to_share(total: int, room: list[int]) -> Float[np.ndarray, "B N"]:
    """(A + 1, total + 1) in how many ways each number up to `total` goes into the bins from the i-th on."""
    ways = np.zeros((len(room) + 1, total + 1))
    ways[-1, 0] = 1.0
    for i in range(len(room) - 1, -1, -1):
        until = np.cumsum(ways[i + 1])
        ways[i] = until
        ways[i, room[i] + 1 :] -= until[: max(total - room[i], 0)]
    return ways


def _drawn_share(ways: Float[np.ndarray, "B N"], room: list[int], rng: np.random.Generator) -> tuple[int, ...]:
    """One way to share all there is among bins with so much room, all as likely; `ways` as `_ways_to_share` tells."""
    left, counts = ways.shape[1] - 1, []
    for most, after in zip(room, ways[1:], strict=True):
        likely = after[left - np.arange(min(most, left) + 1)]
        counts.append(int(rng.choice(len(likely), p=likely / likely.sum())))
        left -= counts[-1]
    return tuple(counts)


def _tightened(arcs: Float[np.ndarray, "m 2"], gap: float, fixed: tuple[float, ...]) -> Arcs | None:
    """Shift the (m, 2) arcs of m cameras by i x gap and cut off what no feasible layout reaches; None if empty."""
    n_free = len(arcs)
    shift = gap * np.arange(n_free)
    lower = np.maximum.accumulate(arcs[:, 0] - shift)
    upper = np.minimum.accumulate((arcs[:, 1] - shift)[::-1])[::-1]
    slack = TURN - n_free * gap
    if n_free:
        lower[0] = max(lower[0], lower[-1] - slack)
        lower = np.maximum.accumulate(lower)
    if (lower > upper).any() or slack < 0:
        return None
    return Arcs(lower, upper.copy(), np.asarray(slack), np.asarray(fixed, dtype=np.float64))
