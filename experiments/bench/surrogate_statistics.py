"""Statistics of an estimate against the truth: rank, size of errors, what to expect of samples, gradients."""

from collections.abc import Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from scipy.stats import spearmanr

from placement.surrogate.soft_coverage import soft_coverage_of
from placement.surrogate.surrogate import Surrogate

# Half the step of central differences [rad]: rounding costs some 1e-8 of a gradient, curvature at the coldest
# temperature of 0.005 rad the same, and grid angles, where soft coverage has a kink, are hardly ever so near.
DIFFERENCE_STEP = 1e-6


def rank_correlation(estimates, areas) -> float | None:
    """Spearman's rank correlation; None where all of one side are equal, and there is nothing to rank.

    Examples
    --------
    >>> round(rank_correlation([1.0, 2.0, 4.0, 3.0], [10.0, 20.0, 30.0, 40.0]), 9)
    0.8
    >>> rank_correlation([1.0, 1.0], [1.0, 2.0]) is None
    True
    """
    if np.ptp(estimates) == 0 or np.ptp(areas) == 0:
        return None
    return float(spearmanr(estimates, areas).statistic)  # pyright: ignore[reportAttributeAccessIssue]


def error_sizes(errors) -> tuple[float, float, float]:
    """Mean of the absolute errors, what 95 % of them do not exceed, and the greatest.

    Examples
    --------
    >>> error_sizes(np.array([-4.0, 0.0, 2.0]))[::2]
    (2.0, 4.0)
    """
    sizes = np.abs(errors)
    return float(sizes.mean()), float(np.quantile(sizes, 0.95)), float(sizes.max())


def standard_error(covered: np.ndarray, weights: np.ndarray) -> float:
    """Standard error of the covered area of stratified samples, one in each stratum, in their order.

    The squared difference of two neighbours stands for the sum of their variances ("collapsed strata"; Cochran,
    *Sampling Techniques*, 5A.12). It also holds what really differs between the two, so it is a little too large.

    Parameters
    ----------
    covered : (N,) ndarray of bool
        Whether each sample is reconstructable.
    weights : (N,) ndarray
        Area each one stands for [mm²].

    Examples
    --------
    >>> standard_error(np.array([True, True, False, True, False, False]), np.ones(6))
    1.0
    """
    counted = weights * covered
    even = len(counted) // 2 * 2
    return float(np.sqrt(np.square(counted[0:even:2] - counted[1:even:2]).sum()))


def least(values: Sequence[float | None]) -> float | None:
    """The least of those that are there; None where none is."""
    return min((value for value in values if value is not None), default=None)


def gradient_error(surrogate: Surrogate, layouts: Sequence[np.ndarray], temperature: float) -> float:
    """Largest error of the gradient of soft coverage against central differences, as part of the largest derivative.

    Parameters
    ----------
    surrogate : Surrogate
    layouts : sequence of (M,) ndarray
        Ring angles [rad].
    temperature : float
        Width of the soft step [rad], above 0.

    Examples
    --------
    >>> import exact
    >>> from placement.samples.profiles import RingProfiles
    >>> one_point = RingProfiles.of(np.array([[1.5], [0.0], [-1.5], [0.0]]), np.ones(1))
    >>> surrogate = Surrogate(one_point, exact.Demand(), exact.Ring())
    >>> gradient_error(surrogate, [np.array([-0.5, 0.7])], temperature=0.3) < 1e-6
    True
    """
    largest = 0.0
    for layout in layouts:
        slope = np.asarray(
            gradient(jnp.asarray(layout), surrogate.points, jnp.asarray(temperature), surrogate.demand.threshold)
        )
        difference = np.empty_like(slope)
        for camera, step in enumerate(DIFFERENCE_STEP * np.eye(len(layout))):
            ahead, behind = surrogate.at(layout + step, temperature), surrogate.at(layout - step, temperature)
            difference[camera] = (ahead - behind) / (2 * DIFFERENCE_STEP)
        scale = np.abs(difference).max()
        if scale > 0:
            largest = max(largest, float(np.abs(slope - difference).max() / scale))
    return largest


@eqx.filter_jit
@eqx.filter_grad
def gradient(angles, points, temperature, threshold):
    """(M,) derivatives of soft coverage by the ring angles; `points` are a `Surrogate`'s, scalars are arrays."""
    return soft_coverage_of(points, angles, temperature, threshold)
