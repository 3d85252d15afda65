"""Solve a grid program, by whichever of two ways is quicker: both give an upper bound that holds for every choice.

- *Enumeration*, all choices, where there are not too many.
- *Branch and bound* on linear programs for what is too many.
"""

import math
import time

import numpy as np

from placement.proof.branching import branch_and_bound
from placement.proof.enumeration import enumerate_all, enumerate_spread
from placement.proof.grid_program import GridProgram, GridSolution

# Multiplications up to which enumeration is taken, within seconds.
QUICK_MULTIPLICATIONS = 2e11
# Pairs of cameras at a point that are looked at one by one, within seconds too.
QUICK_PAIRS = 1e9


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
    end = time.perf_counter() + seconds
    small = program.merged()
    found = None
    if is_quick(small):
        found = enumerate_spread(small, end) if small.is_spread else enumerate_all(small, end)
    return found or branch_and_bound(small, max(end - time.perf_counter(), 1.0), gap, known=known)


def is_quick(program: GridProgram) -> bool:
    """Whether enumeration takes seconds.

    It multiplies for each choice, point and count below the threshold; where cameras must lie apart it looks at each
    choice, point and pair of cameras.
    """
    n, free = program.n_free, int(program.allowed.sum()) - max(program.window - 1, -1) * (program.n_free - 1)
    choices = np.prod([max(free - i, 0) / (i + 1) for i in range(n)]) if n else 1.0
    work = float(choices) * len(program.weights)
    if program.is_spread:
        return work * max(1, math.comb(n + len(program.fixed), 2)) <= QUICK_PAIRS
    return 2 * work * program.threshold <= QUICK_MULTIPLICATIONS  # twice: blocks hold choices in vain
