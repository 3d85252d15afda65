"""Linear programs, some of their variables whole, that HiGHS minimises."""

from concurrent.futures import ThreadPoolExecutor

import highspy
import numpy as np
import scipy.sparse as sparse


class LinearProgram(highspy.Highs):
    """A program in one thread and without words, built from columns and rows.

    Examples
    --------
    >>> program = LinearProgram(mip_rel_gap=0.0)
    >>> program.columns([-1.0, -1.0], [0.0, 0.0], [1.0, 1.0], whole=True)
    >>> program.rows([[2.0, 1.0]], -np.inf, 2.0)
    >>> program.solve_within(10.0) == highspy.HighsModelStatus.kOptimal, program.getInfo().objective_function_value
    (True, -1.0)
    """

    def __init__(self, **options: float | str):
        super().__init__()
        for option, value in {"output_flag": False, "threads": 1, **options}.items():
            self.setOptionValue(option, value)
        self.HandleUserInterrupt = True  # `cancelSolve` stops it

    def columns(self, cost, low, high, whole: bool = False) -> None:
        """Add variables with their cost and limits."""
        first, none = self.getNumCol(), np.zeros(0, dtype=np.int32)
        cost, low, high = (np.array(one, dtype=np.float64) for one in (cost, low, high))
        self.addCols(len(cost), cost, low, high, 0, none, none, np.zeros(0))
        for column in range(first, self.getNumCol()) if whole else ():
            self.changeColIntegrality(column, highspy.HighsVarType.kInteger)

    def rows(self, matrix, low, high) -> None:
        """Add `low` <= `matrix` x <= `high`, limits as arrays or one for all."""
        matrix = sparse.csr_matrix(matrix)
        n_rows = len(matrix.indptr) - 1
        low, high = (np.broadcast_to(np.asarray(one, dtype=np.float64), n_rows).copy() for one in (low, high))
        start, index = matrix.indptr[:-1].astype(np.int32), matrix.indices.astype(np.int32)
        self.addRows(n_rows, low, high, matrix.nnz, start, index, matrix.data.astype(np.float64))

    def solve_within(self, seconds: float) -> highspy.HighsModelStatus:
        """Minimise for at most so many seconds, further from where it stands if it was solved before.

        In a thread, since an interrupt would otherwise only be raised when all is done.
        """
        self.setOptionValue("time_limit", self.getRunTime() + seconds)
        with ThreadPoolExecutor(1) as thread:
            done = thread.submit(self.run)
            try:
                done.result()
            except BaseException:
                self.cancelSolve()
                raise
        return self.getModelStatus()
