"""What cameras reconstruct of sample points, given which of the points each of them sees."""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array

import exact
from exact.demand import Criterion
from placement.errors import PlacementError
from placement.samples.profiles import RingProfiles

# Cameras whose squared distances from their centre add up to less [mm²] are in one place.
LEAST_SPREAD = 1e-9
# How much the mean of several sites counts beside the least: enough to lead over flat stretches, too little to decide.
MEAN_SHARE = 0.01
# Errors on a ring follow its formula to 0.3 %.
NEARLY_EXACT = 1.003


class ViewedSamples:
    """Judges cameras at ring angles by given views of the samples.

    Parameters
    ----------
    profiles : RingProfiles
        Of which weights, sites and noises matter here, and no profiles.
    demand : exact.Demand
        What makes a point count.
    ring : exact.Ring
        Where cameras may be.

    Examples
    --------
    >>> profiles = RingProfiles.of(np.ones((4, 3)), np.array([4.0, 2.0, 1.0]))
    >>> viewed = ViewedSamples(profiles, exact.Demand(), exact.Ring())
    >>> viewed.fraction(np.array([[True, True, False], [True, False, True]]), np.array([0.0, 1.0]))
    4.0
    """

    def __init__(self, profiles: RingProfiles, demand: exact.Demand, ring: exact.Ring):
        self.profiles, self.demand, self.ring = profiles, demand, ring
        self._weights = profiles.weights.astype(np.float32)

    def met(self, seen: Bool[np.ndarray, "M N"], theta: Float[np.ndarray, " M"]) -> Bool[np.ndarray, " N"]:
        """(N,) bool: which samples cameras at these ring angles [rad] reconstruct that see them so."""
        return samples_met(seen, theta, self.demand, self.ring, self.profiles.noise, self.profiles.heights)

    def fraction(self, seen: Bool[np.ndarray, "M N"], theta: Float[np.ndarray, " M"]) -> float:
        """Weight of what they reconstruct; the least of several sums."""
        return float(self.profiles.sums(self.met(seen, theta)).min())

    def worth(self, seen: Bool[np.ndarray, "M N"], theta: Float[np.ndarray, " M"]) -> float:
        """`fraction` and, of several sums, a little of their mean."""
        return float(worth_of(self.profiles.sums(self.met(seen, theta))))

    def error(self, seen: Bool[np.ndarray, "M N"], theta: Float[np.ndarray, " M"]) -> float:
        """Root mean square of the predicted errors over what they reconstruct [mm]; inf for nothing."""
        covered = self.met(seen, theta)
        weights = self.profiles.weights[covered]
        variances = variances_of(seen[:, covered], theta, self.ring, self.profiles.noise[covered])
        return float(np.sqrt(weights @ variances / weights.sum())) if weights.sum() > 0 else np.inf

    def worth_with_one_more(
        self,
        seen: Bool[np.ndarray, "M N"],
        theta: Float[np.ndarray, " M"],
        now_seen: Float[np.ndarray, "N G"],
        grid: Float[np.ndarray, " G"],
    ) -> Float[np.ndarray, " G"]:
        """(G,) `worth` with one more camera at each of the angles of `grid` [rad], that sees 1 of `now_seen`."""
        count = seen.sum(axis=0)
        threshold = self.demand.threshold
        if self.demand.is_count:
            already = self.profiles.sums(count >= threshold)
            return worth_of(self._sums(np.flatnonzero(count == threshold - 1), now_seen) + already[:, None])
        # One camera more undoes nothing: it only adds pairs and lessens errors.
        done = self.met(seen, theta)
        waiting = np.flatnonzero((count >= threshold - 1) & ~done)
        newly = now_seen[waiting] > 0
        won = self._covered_with_one_more(theta, seen[:, waiting], newly, grid)
        if self.demand.max_disparity_gradient is not None:
            won &= self._matched_with_one_more(theta, seen[:, waiting], newly, grid, self.profiles.heights[:, waiting])
        if self.demand.max_error is not None:
            noise = self.profiles.noise[waiting]
            won &= self._variances(theta, seen[:, waiting], newly, grid, noise) <= self.demand.max_error**2
        weights = self._weights[waiting] * (self.profiles.site[waiting] == np.arange(self.profiles.n_sites)[:, None])
        gained = weights.astype(np.float32) @ won.astype(np.float32)
        return worth_of(gained.astype(np.float64) + self.profiles.sums(done)[:, None])

    def worth_with_two_more(
        self, seen: Bool[np.ndarray, "M N"], now_seen: Float[np.ndarray, "N G"]
    ) -> Float[np.ndarray, "G G"]:
        """(G, G) `worth` with two more cameras, where nothing but cameras enough are needed."""
        short = self.demand.threshold - seen.sum(axis=0)
        sums = []
        for site, already in enumerate(self.profiles.sums(short <= 0)):
            # A point one view short is won by either camera, one two views short only by both.
            one = np.flatnonzero((short == 1) & (self.profiles.site == site))
            two = np.flatnonzero((short == 2) & (self.profiles.site == site))
            either, both = now_seen[one], now_seen[two]
            alone = self._weights[one] @ either
            gained = alone[:, None] + alone[None, :] - (either.T * self._weights[one]) @ either
            sums.append((gained + (both.T * self._weights[two]) @ both).astype(np.float64) + already)
        return worth_of(np.stack(sums))

    def worth_with_two_matched_more(
        self,
        seen: Bool[np.ndarray, "M N"],
        theta: Float[np.ndarray, " M"],
        now_seen: Float[np.ndarray, "N G"],
        grid: Float[np.ndarray, " G"],
    ) -> Float[np.ndarray, "G G"]:
        """(G, G) `worth` with two more cameras, where some two of them must match and that is all."""
        done = self.met(seen, theta)
        waiting = np.flatnonzero(~done & (now_seen > 0).any(axis=1))
        newly, heights = now_seen[waiting] > 0, self.profiles.heights[:, waiting]
        alone = self._matched_with_one_more(theta, seen[:, waiting], newly, grid, heights)
        lost, left = (~alone).astype(np.float32), (newly & ~alone).astype(np.float32)
        own = (np.asarray(self.demand.max_disparity_gradient) / 2 * (heights.T @ around(grid))).astype(np.float32)
        chords = chords_of(grid, grid, self.ring)
        far, sums = self.demand.apart(chords), []
        for site, already in enumerate(self.profiles.sums(done)):
            of_site = np.flatnonzero(self.profiles.site[waiting] == site)
            weights = self._weights[waiting][of_site]
            gained = weights.sum() - (lost[of_site].T * weights) @ lost[of_site]
            for place, chord in enumerate(chords.astype(np.float32)):
                which = of_site[left[of_site, place] > 0]
                matched = left[which] * (chord - own[which] <= own[which, place, None])
                gained[place] += np.einsum("n,ng->g", self._weights[waiting][which], matched) * far[place]
            sums.append(gained.astype(np.float64) + already)
        return worth_of(np.stack(sums))

    def measured_with_one_more(
        self,
        seen: Bool[np.ndarray, "M N"],
        theta: Float[np.ndarray, " M"],
        seen_from: Float[np.ndarray, "N G"] | Bool[np.ndarray, "N G"],
        grid: Float[np.ndarray, " G"],
    ) -> tuple[Float[np.ndarray, " G"], Float[np.ndarray, " G"]]:
        """`worth` and `error` with one more camera at each of the angles of `grid` [rad].

        What makes points of one site differ that the same cameras see is their noise alone, by which variances grow,
        and their heights, if disparities are bounded.
        """
        which = np.flatnonzero(seen.sum(axis=0) >= self.demand.threshold - 1)
        key = np.concatenate([np.packbits(seen[:, which], axis=0), self.profiles.site[None, which]])
        order = np.lexsort(key)
        which, key = which[order], key[:, order]
        begins = np.append(0, np.flatnonzero((key[:, 1:] != key[:, :-1]).any(axis=0)) + 1)[: len(which)]
        sets, site = seen[:, which[begins]], self.profiles.site[which[begins]]
        ends = np.append(begins, len(which))
        alone, joined = self._unit_variances(theta, sets, grid)
        weight, noise = self.profiles.weights[which], self.profiles.noise[which]
        now = seen_from[which].astype(np.float64)
        without = 1 - now
        if self.demand.max_disparity_gradient is not None:
            heights = self.profiles.heights[:, which]
            without[~samples_matched(seen[:, which], theta, self.demand, self.ring, heights)] = 0.0
            now[~self._matched_with_one_more(theta, seen[:, which], now > 0, grid, heights)] = 0.0
        if self.demand.max_error is not None:
            group, most = np.repeat(np.arange(len(begins)), np.diff(ends)), self.demand.max_error**2
            with np.errstate(invalid="ignore"):
                without[~(noise * alone[group] <= most)] = 0.0
                now[~(noise[:, None] * joined[group] <= most)] = 0.0
        columns, n = np.arange(len(which)), (len(begins), len(which))
        sums = [csr_array((values, columns, ends), shape=n) for values in (weight, weight * noise)]
        counts = self._covered_with_one_more(theta, sets, np.ones((len(begins), len(grid)), dtype=bool), grid)
        weights, squares = _counted(sums[0] @ now, sums[1] @ now, joined, counts)
        counts = self._covered_with_one_more(theta, sets, np.zeros((len(begins), 1), dtype=bool), grid[:1])
        if counts.any():
            more = _counted(sums[0] @ without, sums[1] @ without, alone[:, None], counts)
            weights, squares = weights + more[0], squares + more[1]
        total, squares = weights.sum(axis=0), squares.sum(axis=0)
        error = np.sqrt(np.divide(squares, total, out=np.full(len(grid), np.inf), where=total > 0))
        return worth_of(np.stack([weights[site == k].sum(axis=0) for k in range(self.profiles.n_sites)])), error

    def _unit_variances(
        self, theta: Float[np.ndarray, " M"], sets: Bool[np.ndarray, "M S"], grid: Float[np.ndarray, " G"]
    ) -> tuple[Float[np.ndarray, " S"], Float[np.ndarray, "S G"]]:
        """Variances of points of unit noise that these sets of cameras see, without and with one more of `grid`."""
        joined = self._variances(
            theta, sets, np.ones((sets.shape[1], len(grid)), dtype=bool), grid, np.ones(sets.shape[1])
        )
        return variances_of(sets, theta, self.ring, np.ones(sets.shape[1])), joined

    def _covered_with_one_more(
        self,
        theta: Float[np.ndarray, " M"],
        seen: Bool[np.ndarray, "M W"],
        now_seen: Bool[np.ndarray, "W G"],
        grid: Float[np.ndarray, " G"],
    ) -> Bool[np.ndarray, "W G"]:
        """Whether cameras enough see W points, and far enough apart, with one more at each of `grid`."""
        covered = seen.sum(axis=0)[:, None] + now_seen >= self.demand.threshold
        if self.demand.baseline > 0:
            paired = Criterion(2, far_apart(theta, theta, self.demand, self.ring)).enough(seen.T)
            partner = seen.T.astype(np.float32) @ far_apart(theta, grid, self.demand, self.ring).astype(np.float32) > 0
            covered &= paired[:, None] | (partner & now_seen)
        return covered

    def _matched_with_one_more(
        self,
        theta: Float[np.ndarray, " M"],
        seen: Bool[np.ndarray, "M W"],
        now_seen: Bool[np.ndarray, "W G"],
        grid: Float[np.ndarray, " G"],
        heights: Float[np.ndarray, "3 W"],
    ) -> Bool[np.ndarray, "W G"]:
        """Whether two cameras match W points that see them, with one more at each of `grid`."""
        chords = chords_of(theta, grid, self.ring)
        far, most = self.demand.apart(chords), np.asarray(self.demand.max_disparity_gradient) / 2
        before = samples_matched(seen, theta, self.demand, self.ring, heights)
        # Single precision: what it decides, exact areas decide again.
        won, directions = np.repeat(before[:, None], len(grid), axis=1), around(grid)
        for camera, (chord, is_far) in enumerate(zip(chords, far, strict=True)):
            which = np.flatnonzero(seen[camera] & ~before)
            there = (most * (heights[:, which].T @ directions)).astype(np.float32)
            own = (most * (around(theta[camera : camera + 1])[:, 0] @ heights[:, which])).astype(np.float32)
            matched = chord.astype(np.float32) - there <= own[:, None]
            won[which] |= matched & now_seen[which] & is_far
        return won

    def _variances(
        self,
        theta: Float[np.ndarray, " M"],
        seen: Bool[np.ndarray, "M W"],
        now_seen: Bool[np.ndarray, "W G"],
        grid: Float[np.ndarray, " G"],
        noise: Float[np.ndarray, " W"],
    ) -> Float[np.ndarray, "W G"]:
        """Variances [mm²] of the errors of W points with one more camera at each of `grid`."""
        moment = (np.exp(1j * theta) @ seen)[:, None] + np.where(now_seen, np.exp(1j * grid), 0)
        return _variances(seen.sum(axis=0)[:, None] + now_seen, moment, self.ring, noise[:, None])

    def _sums(self, waiting: Int[np.ndarray, " W"], now_seen: Float[np.ndarray, "N G"]) -> Float[np.ndarray, "S G"]:
        """(n_sites, G) weight of the `waiting` samples that each further camera sees."""
        sums = []
        for site in range(self.profiles.n_sites):
            of_site = waiting[self.profiles.site[waiting] == site]
            # einsum, not BLAS: for products this small, threads that wait for each other cost more than they bring.
            sums.append(np.einsum("n,ng->g", self._weights[of_site], now_seen[of_site]).astype(np.float64))
        return np.stack(sums)


def samples_met(
    seen: Bool[np.ndarray, "M N"],
    angles: Float[np.ndarray, " M"],
    demand: exact.Demand,
    ring: exact.Ring,
    noise: Float[np.ndarray, " N"],
    heights: Float[np.ndarray, "3 N"],
) -> Bool[np.ndarray, " N"]:
    """(N,) bool: which samples the cameras at these ring angles [rad] reconstruct.

    `noise` and `heights` are as of `RingProfiles`.
    """
    far = far_apart(angles, angles, demand, ring) if demand.baseline > 0 else None
    met = Criterion(demand.threshold, far).enough(seen.T)
    if demand.max_disparity_gradient is not None:
        met[met] = samples_matched(seen[:, met], angles, demand, ring, heights[:, met])
    if demand.max_error is not None:
        met[met] = variances_of(seen[:, met], angles, ring, noise[met]) <= demand.max_error**2
    return met


def samples_matched(
    seen: Bool[np.ndarray, "M N"],
    angles: Float[np.ndarray, " M"],
    demand: exact.Demand,
    ring: exact.Ring,
    heights: Float[np.ndarray, "3 N"],
) -> Bool[np.ndarray, " N"]:
    """(N,) bool: which samples two cameras see that match them: far enough apart, by a small enough gradient."""
    matched = np.zeros(seen.shape[1], dtype=bool)
    for one, other in zip(*np.nonzero(np.triu(far_apart(angles, angles, demand, ring), k=1)), strict=True):
        matched |= seen[one] & seen[other] & pair_matches(angles[[one, other]], demand, ring, heights)
    return matched


def pair_matches(
    angles: Float[np.ndarray, "2"], demand: exact.Demand, ring: exact.Ring, heights: Float[np.ndarray, "3 N"]
) -> Bool[np.ndarray, " N"]:
    """(N,) bool: on which samples' faces the gradient of the cameras at two ring angles [rad] is small enough."""
    chord = ring.diameter * np.abs(np.sin((angles[0] - angles[1]) / 2))
    mean = around(angles).mean(axis=1) @ heights
    return chord <= np.asarray(demand.max_disparity_gradient) * mean


def around(angles: Float[np.ndarray, " M"]) -> Float[np.ndarray, "3 M"]:
    """(3, M): 1, cosine and sine of ring angles [rad], for what is linear in a camera's position."""
    return np.stack([np.ones(len(angles)), np.cos(angles), np.sin(angles)])


def far_apart(
    first: Float[np.ndarray, " A"], second: Float[np.ndarray, " B"], demand: exact.Demand, ring: exact.Ring
) -> Bool[np.ndarray, "A B"]:
    """(A, B) bool: ring angles [rad] that are far enough apart."""
    return demand.apart(chords_of(first, second, ring))


def chords_of(
    first: Float[np.ndarray, " A"], second: Float[np.ndarray, " B"], ring: exact.Ring
) -> Float[np.ndarray, "A B"]:
    """(A, B) distances [mm] between cameras at ring angles [rad]."""
    return ring.diameter * np.abs(np.sin((first[:, None] - second[None, :]) / 2))


def variances_of(
    seen: Bool[np.ndarray, "M N"], angles: Float[np.ndarray, " M"], ring: exact.Ring, noise: Float[np.ndarray, " N"]
) -> Float[np.ndarray, " N"]:
    """(N,) predicted variances [mm²] of samples that the cameras at these ring angles [rad] see; `noise` in [mm⁴]."""
    # By einsum, not BLAS, whose threads wait for each other.
    return _variances(seen.sum(axis=0), np.einsum("m,mn->n", np.exp(1j * angles), seen), ring, noise)


def refuse_unmet(profiles: RingProfiles, demand: exact.Demand, ring: exact.Ring, n_cameras: int) -> None:
    """Refuse a bound on the error that no layout meets at any of the samples.

    However many cameras see a point, their squared distances from their centre add up to (d/2)² each at most.

    Raises
    ------
    PlacementError
        With the least error that can be met.
    """
    if demand.max_error is None or len(profiles.noise) == 0:
        return
    least = float(np.sqrt(profiles.noise.min() / n_cameras)) / (ring.diameter / 2)
    if least > NEARLY_EXACT * demand.max_error:
        raise PlacementError(
            f"max_error is {demand.max_error:g} mm; {n_cameras} cameras on this ring place no point of the surface "
            f"better than to {least:.3g} mm: allow a larger error, or take more cameras, a wider or nearer ring, more "
            "pixels or a lower noise of a match"
        )


def _variances(count: np.ndarray, moment: np.ndarray, ring: exact.Ring, noise: np.ndarray) -> np.ndarray:
    """The same from the number n of cameras that see each point and the sum m of their e^(i θ).

    The squared distances of the cameras from their centre add up to (d/2)² (n - |m|² / n).
    """
    spread = (ring.diameter / 2) ** 2 * (count - np.abs(moment) ** 2 / np.maximum(count, 1))
    return np.divide(noise, spread, out=np.full(np.broadcast(noise, spread).shape, np.inf), where=spread > LEAST_SPREAD)


def _counted(sums: np.ndarray, squares: np.ndarray, variance: np.ndarray, counts: np.ndarray):
    """Sums of weights that count, and of squares, from those of unit variance; infinite only where there is any."""
    sums, known = np.where(counts, sums, 0.0), np.isfinite(variance)
    squares = np.where(known & (sums > 0), squares, 0.0) * np.where(known, variance, 0.0)
    return sums, np.where(~known & (sums > 0), np.inf, squares)


def worth_of(sums: Float[np.ndarray, "S ..."]) -> Float[np.ndarray, "..."]:
    """The least along the first axis and, where there are several, MEAN_SHARE of their mean."""
    return np.asarray(sums[0] if len(sums) == 1 else sums.min(axis=0) + MEAN_SHARE * sums.mean(axis=0))
