"""Solve a grid program, by whichever of three ways is quickest: all give an upper bound that holds for every choice.

- *Enumeration*, all choices, where there are not too many.
- *Enumeration in groups* of places, of which the best are divided, where any two cameras make a point count.
- *Branch and bound* on linear programs for the rest.
"""

import time
from dataclasses import replace

import numpy as np

from placement.proof.branching import branch_and_bound
from placement.proof.enumeration import enumerate_all, enumerate_spread, is_quick
from placement.proof.grid_program import GridProgram, GridSolution
from placement.proof.halving import halved


def solve(program: GridProgram, seconds: float, gap: float, known: tuple[int, ...] | None = None) -> GridSolution:
    """Best choice and upper bound, by enumeration where that is quick enough.

    Parameters
    ----------
    program : GridProgram
        The problem.
    seconds : float
        Time limit [s]; when it runs out the bound still holds.
    gap : float
        Branch and bound stops when bound and value differ by less than this fraction.
    known : tuple of int, optional
        A choice that is allowed: what cannot be better is left out, and it is taken if no better one is found in time.

    Examples
    --------
    >>> seen = np.array([[1, 1, 0], [1, 0, 0], [0, 1, 1], [0, 0, 1]], dtype=bool)
    >>> none, anyhow = np.zeros((0, 3), bool), np.zeros(3)
    >>> weights, allowed = np.array([1.0, 2.0, 4.0]), np.ones(4, bool)
    >>> program = GridProgram(seen, weights, 2, 2, 1, allowed, np.zeros(3, int), anyhow, none, np.zeros(0))
    >>> found = solve(program, seconds=10.0, gap=1e-3)
    >>> found.places, found.value, found.method
    ((2, 3), 4.0, 'enumeration')
    """
    begun = time.perf_counter()
    end, small = begun + seconds, program.merged()
    if is_quick(small):
        found = enumerate_spread(small, end) if small.is_spread else enumerate_all(small, end)
        if found is not None:
            return found
    found = None if small.is_spread or small.n_free == 0 else halved(program, known, -np.inf, begun + seconds / 2)
    if found is not None and (found.finished or found.bound <= found.value * (1 + gap)):
        return replace(found, finished=True)
    known = known if found is None else found.places
    rest = branch_and_bound(small, max(end - time.perf_counter(), 1.0), gap, known=known)
    return rest if found is None or rest.bound <= found.bound else replace(rest, bound=found.bound)
