"""How many cameras placing saves: the fewest that reach a target, optimised and equidistant, site by site."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.study.rows import EquidistantRow, LayoutRow

TARGETS = (0.95, 0.99, 0.999)


@dataclass(frozen=True)
class Saving:
    """The fewest cameras on one site that reach a target; None if none of the numbers tried does."""

    site: str
    depth_mm: int
    target: float
    optimised: int | None
    equidistant: int | None

    @property
    def saved(self) -> int | None:
        """Cameras saved, where both are known."""
        return None if self.optimised is None or self.equidistant is None else self.equidistant - self.optimised


def savings(layouts: Sequence[LayoutRow], even: Sequence[EquidistantRow]) -> list[Saving]:
    """One for each site and target.

    Examples
    --------
    >>> rows = [LayoutRow("layouts", "x", 50, n, 5.0, 0.0, "mean", fraction=f) for n, f in ((2, 0.9), (3, 0.96))]
    >>> found = savings(rows, [EquidistantRow("x", 50, n, f) for n, f in ((4, 0.94), (5, 0.97))])
    >>> found[0].optimised, found[0].equidistant, found[0].saved, found[1].saved
    (3, 5, 2, None)
    """
    found = []
    for site, depth in sites_of(layouts):
        best = {row.n_cameras: row.fraction for row in layouts if _is_of(row, site, depth) and row.part == "layouts"}
        ring = {row.n_cameras: row.fraction for row in even if _is_of(row, site, depth)}
        for target in TARGETS:
            found.append(Saving(site, depth, target, _fewest(best, target), _fewest(ring, target)))
    return found


def headline(found: Sequence[Saving]) -> list[str]:
    """For each target one sentence about all sites."""
    words = []
    for target in TARGETS:
        rows = [one for one in found if one.target == target]
        both = [one.saved for one in rows if one.saved is not None]
        fewer = [saved for saved in both if saved > 0]
        sentence = f"{percent(target)} of the ring maximum: fewer optimised than equidistant cameras reach it on "
        sentence += f"{len(fewer)} of {len(rows)} sites"
        if fewer:
            least, most = min(fewer), max(fewer)
            span = f"{least}" if least == most else f"{least} to {most}"
            sentence += f", {span} fewer there and {np.mean(both):.1f} fewer on the mean of the {len(both)} sites"
            sentence += " where both reach it"
        unknown = len(rows) - len(both)
        if unknown:
            sentence += f"; on {unknown} it is out of reach of the numbers of cameras tried"
        words.append(sentence + ".")
    return words


def sites_of(layouts: Sequence[LayoutRow]) -> list[tuple[str, int]]:
    """Sites and depths [mm] in the order of the rows about single sites."""
    return list(dict.fromkeys((row.site, row.depth_mm) for row in layouts if row.depth_mm is not None))


def percent(fraction: float) -> str:
    """Without needless digits."""
    return f"{100 * fraction:g} %"


def _is_of(row: LayoutRow | EquidistantRow, site: str, depth: int) -> bool:
    return (row.site, row.depth_mm) == (site, depth)


def _fewest(fractions: dict[int, float | None], target: float) -> int | None:
    return min((n for n, fraction in fractions.items() if fraction is not None and fraction >= target), default=None)
