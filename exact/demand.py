"""What counts as reconstructable: for any cameras a `Demand`, for those at hand a `Criterion`."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exact.cameras import Camera
from exact.errors import ExactError
from exact.whole_numbers import is_whole

# Two cameras are far enough apart if they fall short of it by rounding only: positions are rounded to 1e-16 of their
# coordinates, which for a ring 1e6 mm from the origin is 1e-9 of a baseline of a tenth of a millimetre.
SAME_LENGTH = 1e-9


@dataclass(frozen=True)
class Demand:
    """What makes a point of the surface count as reconstructable.

    Parameters
    ----------
    threshold : int
        Number of cameras that must see a point for it to count.
    min_baseline : float
        Least distance between some two of the cameras that see a point [mm].

    Raises
    ------
    ExactError
        If a value makes no sense.

    Examples
    --------
    >>> Demand(threshold=3, min_baseline=15.0).words
    'seen by at least 3 cameras, two of them at least 15 mm apart'
    >>> Demand(threshold=0)
    Traceback (most recent call last):
        ...
    exact.errors.ExactError: threshold is 0; it must be a whole number, at least 1
    """

    threshold: int = 2
    min_baseline: float = 0.0

    def __post_init__(self):
        if isinstance(self.threshold, bool | np.bool) or not (is_whole(self.threshold) and self.threshold >= 1):
            raise ExactError(f"threshold is {self.threshold!r}; it must be a whole number, at least 1")
        object.__setattr__(self, "threshold", int(self.threshold))
        baseline = self.min_baseline
        # Written so that nan is refused, and a whole number that no float can hold.
        if not (isinstance(baseline, int | float | np.number) and 0 <= baseline <= sys.float_info.max):
            raise ExactError(f"min_baseline is {baseline!r}; it must be a number, finite and at least 0 [mm]")
        object.__setattr__(self, "min_baseline", float(baseline))

    @property
    def baseline(self) -> float:
        """Distance that some two of the cameras must keep [mm], whatever asks for it; 0 where any two will do."""
        return self.min_baseline

    @property
    def words(self) -> str:
        """What it takes, as the end of "the area ..."."""
        return f"seen by at least {self.threshold} camera{'' if self.threshold == 1 else 's'}{self._apart_words}"

    def clause(self, of: str = "") -> str:
        """What it takes, as the end of "a point counts when ..."; `of` may say of how many cameras: " of the 4".

        Examples
        --------
        >>> Demand().clause(), Demand(1).clause()
        ('at least 2 cameras see it', 'at least 1 camera sees it')
        """
        see = "camera sees" if self.threshold == 1 else "cameras see"
        return f"at least {self.threshold}{of} {see} it{self._apart_words}"

    @property
    def _apart_words(self) -> str:
        return "" if self.baseline == 0 else f", two of them at least {self.baseline:.4g} mm apart"

    def apart(self, distances: np.ndarray) -> np.ndarray:
        """Which distances between two cameras [mm] are far enough, as an array of bool of the same shape."""
        return np.asarray(distances) >= self.baseline * (1 - SAME_LENGTH)

    def far(self, cameras: Sequence[Camera]) -> np.ndarray | None:
        """(M, M) bool: pairs of (M,) cameras that are far enough apart; None where any two will do."""
        if self.baseline == 0:
            return None
        position = np.array([camera.position for camera in cameras]).reshape(-1, 3)
        return self.apart(np.linalg.norm(position[:, None] - position[None, :], axis=2))

    def of(self, cameras: Sequence[Camera]) -> "Criterion":
        """The same for these (M,) cameras: which sets of them meet it."""
        return Criterion(self.threshold, self.far(cameras))

    def refuse_fewer(self, n_cameras: int) -> None:
        """Refuse a number of cameras that can never meet it.

        Raises
        ------
        ExactError
        """
        if self.threshold > n_cameras:
            raise ExactError(
                f"threshold is {self.threshold} with {n_cameras} cameras; it must be a whole number from 1 to the "
                "number of cameras: add cameras or lower the threshold"
            )


@dataclass(frozen=True, eq=False)
class Criterion:
    """A `Demand` on M given cameras: decides by which of them see a point.

    Attributes
    ----------
    threshold : int
        How many of them must.
    far : (M, M) bool or None
        Pairs of which at least one must; None where any two will do.
    sets : bool
        Whether it matters which cameras see a part, so that only parts that the very same ones see may be merged.
    """

    threshold: int
    far: np.ndarray | None = None
    sets: bool = False

    def met(self, seen: np.ndarray) -> np.ndarray:
        """(N,) whether each row of `seen` (N, M) meets it."""
        enough = np.asarray(seen.sum(axis=1) >= self.threshold)
        return enough if self.far is None else enough & self._paired(seen)

    def state(self, seen: np.ndarray, coming: np.ndarray) -> np.ndarray:
        """(N, K) rows that are equal for parts that will meet it by the same future views `coming` (M,)."""
        if self.sets:
            return seen
        count = np.minimum(seen.sum(axis=1), self.threshold)[:, None]
        if self.far is None:
            return count
        paired = self._paired(seen)[:, None]
        return np.concatenate([count, paired, self._reach(seen)[:, coming] & ~paired], axis=1)

    def _reach(self, seen: np.ndarray) -> np.ndarray:
        """(N, M) whether each camera is far from one that sees the row's part."""
        return seen.astype(np.float32) @ np.asarray(self.far, dtype=np.float32) > 0

    def _paired(self, seen: np.ndarray) -> np.ndarray:
        return np.asarray((seen & self._reach(seen)).any(axis=1))
