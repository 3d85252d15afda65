"""What counts as reconstructable: for any cameras a `Demand`, for those at hand a `Criterion`."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from exact.cameras import Camera, finite_vector
from exact.errors import ExactError
from exact.predicted.bound import ErrorBound, Predictor
from exact.usable.disparity import DisparityLimit
from exact.usable.limits import Limits
from exact.usable.optics import Optics
from exact.visibility.surface import Surface
from exact.whole_numbers import is_whole

# Two cameras are far enough apart if they fall short of it by rounding only: positions are rounded to 1e-16 of their
# coordinates, which for a ring 1e6 mm from the origin is 1e-9 of a baseline of a tenth of a millimetre.
SAME_LENGTH = 1e-9
# Along what an error is measured.
ERRORS = ("depth", "normal")


@dataclass(frozen=True)
class Demand:
    """What makes a point of the surface count as reconstructable.

    Parameters
    ----------
    threshold : int
        Number of cameras that must see a point for it to count.
    min_baseline : float
        Least distance between some two of the cameras that see a point [mm].
    max_disparity_gradient : float, optional
        Greatest disparity gradient of some two of them that are as far apart as that: by how much a match shifts from
        one pixel of an image to the next [pixels]. Semi-global matching bears some 0.5; steep walls then take cameras
        that are close together.
    max_error : float, optional
        Greatest error with which a point may be reconstructed from all cameras that see it: one standard deviation
        [mm].
    error : {"depth", "normal"}
        Along what errors are measured: along `depth_axis`, or along the normal of the surface.
    depth_axis : (3,) tuple of float, optional
        Direction of depth; by default the mean of the cameras' optical axes. On a ring, its axis.
    limits : Limits
        What makes a view usable. A camera sees a point only if its view of it is.
    optics : Optics
        Pixels and lens, which errors and limits depend on.

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
    max_disparity_gradient: float | None = None
    max_error: float | None = None
    error: Literal["depth", "normal"] = "depth"
    depth_axis: tuple[float, float, float] | None = None
    limits: Limits = Limits()
    optics: Optics = Optics()

    def __post_init__(self):
        if isinstance(self.threshold, bool | np.bool) or not (is_whole(self.threshold) and self.threshold >= 1):
            raise ExactError(f"threshold is {self.threshold!r}; it must be a whole number, at least 1")
        object.__setattr__(self, "threshold", int(self.threshold))
        baseline = self.min_baseline
        # Written so that nan is refused, and a whole number that no float can hold.
        if not (isinstance(baseline, int | float | np.number) and 0 <= baseline <= sys.float_info.max):
            raise ExactError(f"min_baseline is {baseline!r}; it must be a number, finite and at least 0 [mm]")
        object.__setattr__(self, "min_baseline", float(baseline))
        for name, unit in (("max_error", " [mm]"), ("max_disparity_gradient", "")):
            largest = getattr(self, name)
            if largest is None:
                continue
            if not (isinstance(largest, int | float | np.number) and 0 < largest <= sys.float_info.max):
                raise ExactError(f"{name} is {largest!r}; it must be a number, positive and finite{unit}")
            object.__setattr__(self, name, float(largest))
        if self.error not in ERRORS:
            raise ExactError(f'error is {self.error!r}; it must be "depth" or "normal"')
        if self.depth_axis is not None:
            axis = finite_vector("depth axis", self.depth_axis, 3)
            if not axis.any():
                raise ExactError("depth axis is the zero vector; give the direction of depth")
            object.__setattr__(self, "depth_axis", tuple(axis.tolist()))
        for name, kind in (("limits", Limits), ("optics", Optics)):
            if not isinstance(getattr(self, name), kind):
                raise ExactError(
                    f"{name} is a {type(getattr(self, name)).__name__}; an exact.{kind.__name__} is needed"
                )
        self.limits.refuse_without(self.optics)

    @property
    def baseline(self) -> float:
        """Distance that some two of the cameras must keep [mm], whatever asks for it; 0 where any two will do."""
        return self.min_baseline

    @property
    def is_count(self) -> bool:
        """Whether it takes nothing but cameras enough, whichever they are."""
        return self.baseline == 0 and self.has_derivative

    @property
    def has_derivative(self) -> bool:
        """Whether the area that meets it has a derivative that is known: neither error nor disparity is bounded."""
        return self.max_error is None and self.max_disparity_gradient is None

    @property
    def words(self) -> str:
        """What it takes, as the end of "the area ..."."""
        return f"seen by at least {self.threshold} camera{'' if self.threshold == 1 else 's'}{self._more_words}"

    def clause(self, of: str = "") -> str:
        """What it takes, as the end of "a point counts when ..."; `of` may say of how many cameras: " of the 4".

        Examples
        --------
        >>> Demand().clause(), Demand(1).clause()
        ('at least 2 cameras see it', 'at least 1 camera sees it')
        """
        see = "camera sees" if self.threshold == 1 else "cameras see"
        return f"at least {self.threshold}{of} {see} it{self._more_words}"

    @property
    def _more_words(self) -> str:
        more = [] if self.baseline == 0 else [f"two of them at least {self.baseline:.4g} mm apart"]
        if self.max_disparity_gradient is not None:
            which = "two of them" if self.baseline == 0 else "these two"
            more.append(f"{which} with a disparity gradient of at most {self.max_disparity_gradient:.4g}")
        more += self.limits.words
        if self.max_error is not None:
            more.append(f"to {self.error} errors of at most {self.max_error:.4g} mm")
        return "".join(f", {words}" for words in more)

    def apart(self, distances: np.ndarray) -> np.ndarray:
        """Which distances between two cameras [mm] are far enough, as an array of bool of the same shape."""
        return np.asarray(distances) >= self.baseline * (1 - SAME_LENGTH)

    def far(self, cameras: Sequence[Camera]) -> np.ndarray | None:
        """(M, M) bool: pairs of (M,) cameras that are far enough apart; None where any two will do."""
        if self.baseline == 0:
            return None
        position = np.array([camera.position for camera in cameras]).reshape(-1, 3)
        return self.apart(np.linalg.norm(position[:, None] - position[None, :], axis=2))

    def of(self, cameras: Sequence[Camera], surface: Surface) -> "Criterion":
        """The same for these (M,) cameras on a surface: which sets of them meet it where."""
        bound = disparity = None
        if self.max_error is not None:
            bound = ErrorBound(self.predictor(cameras, surface), self.max_error, self.error)
        if self.max_disparity_gradient is not None:
            disparity = DisparityLimit(surface, tuple(cameras), self.max_disparity_gradient)
        return Criterion(
            self.threshold, self.far(cameras), disparity, limits=self.limits, optics=self.optics, bound=bound
        )

    def predictor(self, cameras: Sequence[Camera], surface: Surface) -> Predictor:
        """Errors that these cameras make on a surface."""
        axis = self.depth_axis
        if axis is None:
            axis = -np.sum([camera.rotation[2] for camera in cameras], axis=0)
            # Cameras that look at each other leave no common direction: then that of the first.
            axis = -cameras[0].rotation[2] if np.linalg.norm(axis) < SAME_LENGTH * len(cameras) else axis
        axis = np.asarray(axis, dtype=np.float64) / np.abs(axis).max()
        return Predictor(surface, tuple(cameras), self.optics, axis / np.linalg.norm(axis))

    def refuse_fewer(self, n_cameras: int) -> None:
        """Refuse a number of cameras that can never meet it.

        Raises
        ------
        ExactError
        """
        if self.threshold > n_cameras:
            raise ExactError(
                f"threshold is {self.threshold} with {n_cameras} camera{'' if n_cameras == 1 else 's'}; it must be a "
                "whole number from 1 to the number of cameras: add cameras or lower the threshold"
            )
        for name in ("max_error", "max_disparity_gradient"):
            if n_cameras == 1 and getattr(self, name) is not None:
                raise ExactError(f"one camera reconstructs no depth; with {name} at least 2 cameras are needed")


@dataclass(frozen=True, eq=False)
class Criterion:
    """A `Demand` on M given cameras: decides by which of them see a point.

    Attributes
    ----------
    threshold : int
        How many of them must.
    far : (M, M) bool or None
        Pairs of which at least one must; None where any two will do.
    disparity : DisparityLimit or None
        What such a pair must be on the face; None where any will do.
    sets : bool
        Whether it matters which cameras see a part, so that only parts that the very same ones see may be merged.
    limits : Limits
        What makes a view usable.
    optics : Optics
        Of the cameras.
    bound : ErrorBound or None
        The error that a point may have.
    """

    threshold: int
    far: np.ndarray | None = None
    disparity: DisparityLimit | None = None
    sets: bool = False
    limits: Limits = Limits()
    optics: Optics = Optics()
    bound: ErrorBound | None = None

    @property
    def by_set(self) -> bool:
        """Whether parts that different cameras see are always kept apart."""
        return self.sets or self.by_face

    @property
    def by_face(self) -> bool:
        """Whether it also depends on where a part is."""
        return self.bound is not None or self.disparity is not None

    def enough(self, seen: np.ndarray, face: np.ndarray | None = None) -> np.ndarray:
        """(N,) whether each row of `seen` (N, M) are cameras enough, and far enough apart, whatever the error.

        On a part of the face (N,); without it, whether they are on some face.
        """
        enough = np.asarray(seen.sum(axis=1) >= self.threshold)
        if self.far is not None:
            enough &= self._paired(seen)
        if self.disparity is not None and face is not None and enough.any():
            enough[enough] = self.disparity.matched(face[enough], seen[enough], self.far)
        return enough

    def met(self, seen: np.ndarray, face: np.ndarray) -> np.ndarray:
        """(N,) whether each row of `seen` (N, M) meets it all over a part of the face (N,).

        With a bound on the error: whether it surely does. What is left undecided is cut by `predicted.contour`.
        """
        enough = self.enough(seen, face)
        if self.bound is None or not enough.any():
            return enough
        enough[enough] = self.bound.holds_all_over(face[enough], seen[enough])
        return enough

    def settled(self, seen: np.ndarray, possible: np.ndarray, face: np.ndarray) -> np.ndarray:
        """(N,) whether each row of `seen` (N, M) meets it, or views of the `possible` cameras (N, M) cannot help it to.

        What too few cameras see yet is not settled.
        """
        settled = self.met(seen, face)
        # With fewer cameras known than there will be, nothing is hopeless.
        if self.bound is not None and len(self.bound.predictor.cameras) == seen.shape[1]:
            left = np.flatnonzero(self.enough(seen, face) & ~settled)
            settled[left] = self.bound.fails_all_over(face[left], possible[left])
        return settled

    def state(self, seen: np.ndarray, coming: np.ndarray) -> np.ndarray:
        """(N, K) rows that are equal for parts that will meet it by the same future views `coming` (M,)."""
        if self.by_set:
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


def every_view(demand: Demand, cameras: Sequence[Camera]) -> Criterion:
    """What no part ever meets, so that each camera is asked about all of them; with the limits of the demand."""
    return Criterion(len(cameras) + 1, sets=True, limits=demand.limits, optics=demand.optics)
