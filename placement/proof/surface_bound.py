"""What is proven on the surface itself, and its words."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class SurfaceBound:
    """An upper bound for layouts on the grid, from exact areas: fractions of the ring maximum.

    Of several sites it is the mean fraction or that of the worst site, as was asked for.

    Attributes
    ----------
    bound_fraction : float
        No layout on the grid reconstructs more of the surface.
    fraction : float or None
        What the best layout found on the grid reconstructs of it, exactly; None if none was found.
    angles : tuple of float or None
        That layout [rad].
    proven : bool
        Whether the two differ by 0.2 % at most.
    small_fraction : float
        What small sets of cameras add to the bound, which count as covered by any layout.
    n_sets : int
        Sets of cameras whose areas decide.
    method : str
        How the program was solved.
    seconds : float
        Time taken [s].
    ignores_error : bool
        Whether a bound on the predicted error was asked for, which this bound leaves out.
    layout_fraction : float or None
        What the layout in question reconstructs, exactly.
    gap : float or None
        `bound_fraction` less that; below 0 if the layout, off the grid, beats every layout on it.
    """

    bound_fraction: float
    fraction: float | None
    angles: tuple[float, ...] | None
    proven: bool
    small_fraction: float
    n_sets: int
    method: str
    seconds: float = field(compare=False)
    ignores_error: bool
    layout_fraction: float | None = None
    gap: float | None = None

    def words(self, of: str, step: str) -> list[str]:
        """Sentences that say what is proven; `of` what the fractions are of, `step` of the grid in degrees."""
        said = [
            f"On the surface itself no layout with cameras at multiples of {step} degrees reconstructs more than "
            f"{self.bound_fraction:.2%} of {of} ({self.method} over the exact areas of {self.n_sets} sets of cameras)"
        ]
        if self.fraction is not None:
            said[0] += f"; the best one found there reconstructs {self.fraction:.2%}"
        said[0] += "."
        if self.ignores_error:
            said.append("This bound leaves out the one on the error; it holds but may be loose.")
        return said
