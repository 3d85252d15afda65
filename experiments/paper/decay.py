"""How the reconstructable area grows with the number of cameras, as a sum of negative exponential decays.

    A_r(n) = plateau - sum over phases k of amplitude_k exp(-(n - 2) / decay_k)

as in Wachter 2021, Fig. 11, with two or three phases; the corrected Akaike information criterion decides how many. An
amplitude is what a phase lacks at n = 2, where there are data; at n = 0 it would be exp(2 / decay) times as much, which
no data tell for a fast phase.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx

import placement  # noqa: F401 - it switches jax to double precision, without which such sums cannot be told apart
from experiments.paper.published import FIRST

PHASES = (2, 3)
# Starts: decay constants [cameras] that bracket what ten counts from 2 to 360 can show, taken 2 or 3 at a time.
START_DECAYS = (0.6, 1.2, 2.5, 6.0, 15.0, 40.0, 120.0)
# Amplitudes enter as logarithms, so that they stay positive; a start has at least this part of the plateau.
LEAST_AMPLITUDE = 1e-4
# A phase that lacks less than this part of the plateau, or that takes this many cameras, is there in name only.
LEAST_PHASE, SLOWEST = 1e-6, 1e4
# Directions among the parameters along which the curve changes this much less than along others are not told by the
# data, nor is a parameter that has more than this share in one.
APART, SHARE = 1e-7, 1e-3
TOLERANCE = 1e-12
MAX_STEPS = 400


@dataclass(frozen=True)
class DecayFit:
    """One fitted curve.

    Attributes
    ----------
    plateau : float
        Area of infinitely many cameras [mm²].
    amplitudes : tuple of float
        What each phase lacks at 2 cameras, fastest phase first [mm²].
    decays : tuple of float
        Number of cameras in which each phase falls to 1/e.
    plateau_error, amplitude_errors, decay_errors : float, tuple of float
        Standard errors; nan where the data do not determine a parameter.
    r_squared : float
    aicc : float
        Corrected Akaike information criterion, of residuals in units of the plateau; less is better.
    """

    plateau: float
    amplitudes: tuple[float, ...]
    decays: tuple[float, ...]
    plateau_error: float
    amplitude_errors: tuple[float, ...]
    decay_errors: tuple[float, ...]
    r_squared: float
    aicc: float

    @property
    def n_phases(self) -> int:
        """Number of phases."""
        return len(self.decays)


def fit_decays(n_cameras: Sequence[float] | np.ndarray, areas: Sequence[float] | np.ndarray) -> list[DecayFit]:
    """Fit each number of phases that there are enough points for, the best by AICc first.

    Parameters
    ----------
    n_cameras : (N,) array_like
    areas : (N,) array_like
        [mm²]

    Returns
    -------
    list of DecayFit
        Two phases need 8 points, three need 10; none with fewer, or where no start came to an end.

    Examples
    --------
    >>> n = np.array([2, 4, 6, 8, 16, 32, 64, 128, 256, 360])
    >>> fits = fit_decays(n, 1000 - 500 * np.exp(-(n - 2) / 1.5) - 20 * np.exp(-(n - 2) / 30))
    >>> [fit.n_phases for fit in fits]
    [2, 3]
    >>> [round(value, 4) for value in (fits[0].plateau, *fits[0].amplitudes, *fits[0].decays)]
    [1000.0, 500.0, 20.0, 1.5, 30.0]
    >>> fit_decays([2, 4], [1, 2])
    []
    """
    n, areas = np.asarray(n_cameras, dtype=np.float64), np.asarray(areas, dtype=np.float64)
    found = [_fit(n, areas, phases) for phases in PHASES if len(n) >= _n_free(phases) + 2]
    return sorted((fit for fit in found if fit is not None), key=lambda fit: fit.aicc)


def _n_free(phases: int) -> int:
    """Plateau, amplitudes, decays, and the variance of what is left."""
    return 2 * phases + 2


def _fit(n: np.ndarray, areas: np.ndarray, phases: int) -> DecayFit | None:
    scale = float(areas.max())
    starts = jnp.array([_start(n, areas / scale, decays) for decays in combinations(START_DECAYS, phases)])
    ends, losses = _solve(starts, jnp.array(n), jnp.array(areas / scale))
    losses = np.where(np.isfinite(ends).all(axis=1), losses, np.inf)
    if not np.isfinite(losses).any():
        return None
    # Equal ends differ by rounding; the first of the best is as good as any, and the same on every run.
    best = np.array(ends[int(np.argmin(losses))])
    order = np.argsort(best[1 + phases :])
    natural = np.concatenate([best[:1], np.exp(best[1 : 1 + phases])[order], np.exp(best[1 + phases :])[order]])
    left = np.array(_residuals(natural, n, areas / scale))
    jacobian = np.array(jax.jacobian(_residuals)(jnp.array(natural), jnp.array(n), jnp.array(areas / scale)))
    errors = _standard_errors(natural, jacobian, left)
    in_mm2 = np.concatenate([np.full(1 + phases, scale), np.ones(phases)])
    values, errors = natural * in_mm2, errors * in_mm2
    squares, free = float(left @ left), _n_free(phases)
    spread = areas / scale - areas.mean() / scale
    aicc = len(n) * np.log(squares / len(n)) + 2 * free + 2 * free * (free + 1) / (len(n) - free - 1)
    return DecayFit(
        float(values[0]), _floats(values[1 : 1 + phases]), _floats(values[1 + phases :]),
        float(errors[0]), _floats(errors[1 : 1 + phases]), _floats(errors[1 + phases :]),
        1.0 - squares / float(spread @ spread), float(aicc),
    )  # fmt: skip


def _start(n: np.ndarray, heights: np.ndarray, decays: tuple[float, ...]) -> np.ndarray:
    """Plateau and amplitudes that suit these decays best, as far as they are positive."""
    design = np.concatenate([np.ones((len(n), 1)), -np.exp(-(n[:, None] - FIRST) / np.array(decays))], axis=1)
    plateau, *amplitudes = np.linalg.lstsq(design, heights, rcond=None)[0]
    return np.concatenate([[plateau], np.log(np.maximum(amplitudes, LEAST_AMPLITUDE)), np.log(decays)])


def _residuals(natural, n, heights):
    """(N,) differences; `natural` is plateau, amplitudes, decays."""
    phases = (len(natural) - 1) // 2
    return natural[0] - jnp.exp(-(n[:, None] - FIRST) / natural[1 + phases :]) @ natural[1 : 1 + phases] - heights


def _residuals_of_logs(parameters, data):
    return _residuals(parameters.at[1:].set(jnp.exp(parameters[1:])), *data)


@jax.jit
def _solve(starts, n, heights):
    solver = optx.LevenbergMarquardt(rtol=TOLERANCE, atol=TOLERANCE)

    def from_one(start):
        found = optx.least_squares(_residuals_of_logs, solver, start, (n, heights), max_steps=MAX_STEPS, throw=False)
        return found.value, jnp.sum(_residuals_of_logs(found.value, (n, heights)) ** 2)

    return jax.vmap(from_one)(starts)


def _standard_errors(natural: np.ndarray, jacobian: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """Square roots of the diagonal of the usual covariance of a least squares fit; nan where the data tell nothing."""
    n_points, n_parameters = jacobian.shape
    phases = (n_parameters - 1) // 2
    real = (natural[1 : 1 + phases] > LEAST_PHASE * natural[0]) & (natural[1 + phases :] < SLOWEST)
    used = np.flatnonzero(np.concatenate([[True], real, real]))
    # Columns of very unlike size are brought to one before it is asked which of them can be told apart.
    lengths = np.linalg.norm(jacobian[:, used], axis=0)
    lengths[lengths == 0] = 1.0
    _, sizes, directions = np.linalg.svd(jacobian[:, used] / lengths, full_matrices=False)
    told = sizes > APART * sizes[0]
    variance = residuals @ residuals / (n_points - n_parameters)
    errors = np.sqrt(variance * np.sum((directions[told] / sizes[told, None]) ** 2, axis=0)) / lengths
    errors[(np.abs(directions[~told]) > SHARE).any(axis=0)] = np.nan
    every = np.full(n_parameters, np.nan)
    every[used] = errors
    return every


def _floats(values: np.ndarray) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
