"""How many cameras placing saves: the fewest that reach a target, optimised and equidistant, site by site."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.study.rows import EquidistantRow, LayoutRow

TARGETS = (0.95, 0.99, 0.999)
# Of two layouts the one with up to so much more error is as accurate.
LEEWAY = 0.05


@dataclass(frozen=True)
class Saving:
    """The fewest cameras on one site that reach a target; None if none of the numbers tried does.

    `as_accurate` are the fewest optimised ones that reach it as accurately as the `equidistant` ones that do.
    """

    site: str
    depth_mm: int
    target: float
    optimised: int | None
    as_accurate: int | None
    equidistant: int | None

    @property
    def saved(self) -> int | None:
        """Cameras saved, where both are known."""
        return None if self.optimised is None or self.equidistant is None else self.equidistant - self.optimised


def savings(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> list[Saving]:
    """One for each site and target.

    Examples
    --------
    >>> rows = [LayoutRow("layouts", "x", 50, n, 5.0, 0.0, None, "mean", f, e, f, e)
    ...         for n, f, e in ((2, 0.9, 0.1), (3, 0.96, 0.09), (4, 0.97, 0.07))]
    >>> found = savings(rows, [EquidistantRow("x", 50, n, f, e) for n, f, e in ((4, 0.94, 0.09), (5, 0.97, 0.08))])
    >>> found[0].optimised, found[0].as_accurate, found[0].equidistant, found[0].saved, found[1].saved
    (3, 4, 5, 2, None)
    """
    found = []
    for site, depth in sites_of(layouts):
        rows = [row for row in layouts if _is_of(row, site, depth) and row.part == "layouts"]
        rings = [row for row in even if _is_of(row, site, depth)]
        for target in TARGETS:
            enough = [row for row in rings if row.fraction is not None and row.fraction >= target]
            ring = min(enough, key=lambda row: row.n_cameras, default=None)
            reach = [(row.n_cameras, error) for row in rows for fraction, error in _found(row) if fraction >= target]
            accurate = [n for n, error in reach if ring is not None and _as_accurate(error, ring.error_rms_mm)]
            fewest = min((n for n, _ in reach), default=None)
            as_accurate = min(accurate, default=None)
            found.append(Saving(site, depth, target, fewest, as_accurate, None if ring is None else ring.n_cameras))
    return found


def headline(found: Sequence[Saving]) -> list[str]:
    """For each target one sentence about all sites."""
    words = []
    for target in TARGETS:
        rows = [one for one in found if one.target == target]
        both = [one.saved for one in rows if one.saved is not None]
        sentence = f"{percent(target)} of the ring maximum: fewer optimised than equidistant cameras reach it on "
        sentence += _spared(both, len(rows))
        accurate = [
            one.equidistant - one.as_accurate
            for one in rows
            if one.equidistant is not None and one.as_accurate is not None
        ]
        if any(saved > 0 for saved in both):
            sentence += f"; as accurately as those equidistant ones on {_spared(accurate, len(rows))}"
        unknown = len(rows) - len(both)
        if unknown:
            sentence += f"; on {unknown} it is out of reach of the numbers of cameras tried"
        words.append(sentence + ".")
    return words


def accuracy(layouts: Sequence[LayoutRow]) -> list[str]:
    """What most area costs in accuracy, and what the accuracy of the layouts proposed costs in area.

    Examples
    --------
    >>> accuracy([LayoutRow("layouts", "x", 50, 4, 5.0, 0.0, None, "mean", 0.96, 0.08, 0.965, 0.32, 0.94, 0.08)])[1]
    'As proposed it is 1.00 times that on the mean and at most 1.00 times, for at most 0.50 % less of the ring maximum.'
    """
    of = [row for row in layouts if row.part == "layouts" and row.error_rms_mm is not None]
    most, proposed = (
        [getattr(row, name) / row.equidistant_error_rms_mm for row in of]
        for name in ("most_area_error_rms_mm", "error_rms_mm")
    )
    if not of:
        return []
    given_up = max((row.most_area_fraction or 0.0) - (row.fraction or 0.0) for row in of)
    return [
        f"The RMS error in depth of the layouts with most area is {np.mean(most):.2f} times that of as many "
        f"equidistant cameras on the mean over sites and numbers, and up to {max(most):.2f} times.",
        f"As proposed it is {np.mean(proposed):.2f} times that on the mean and at most {max(proposed):.2f} times, for "
        f"at most {100 * given_up:.2f} % less of the ring maximum.",
    ]


def sites_of(layouts: Sequence[LayoutRow]) -> list[tuple[str, int]]:
    """Sites and depths [mm] in the order of the rows about single sites."""
    return list(dict.fromkeys((row.site, row.depth_mm) for row in layouts if row.depth_mm is not None))


def percent(fraction: float) -> str:
    """Without needless digits."""
    return f"{100 * fraction:g} %"


def _is_of(row: LayoutRow | EquidistantRow, site: str, depth: int) -> bool:
    return (row.site, row.depth_mm) == (site, depth)


def _found(row: LayoutRow) -> list[tuple[float, float | None]]:
    """Fraction and error of the layout with most area and of the one proposed."""
    both = ((row.most_area_fraction, row.most_area_error_rms_mm), (row.fraction, row.error_rms_mm))
    return [(fraction, error) for fraction, error in both if fraction is not None]


def _as_accurate(error: float | None, other: float | None) -> bool:
    return error is not None and other is not None and error <= (1 + LEEWAY) * other


def _spared(saved: Sequence[int], n_sites: int) -> str:
    """On how many sites cameras are saved, and how many there, where they may be none."""
    fewer = [one for one in saved if one > 0]
    words = f"{len(fewer)} of {n_sites} sites"
    if fewer:
        span = f"{min(fewer)}" if min(fewer) == max(fewer) else f"{min(fewer)} to {max(fewer)}"
        words += f" ({span} fewer there)"
    return words
