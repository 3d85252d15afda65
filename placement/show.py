"""How a placement looks: the ring from above, and a page for notebooks.

Matplotlib is imported when something is drawn.
"""

from typing import TYPE_CHECKING

import numpy as np

from exact.show import page, rows_html

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from placement.results import Placement

BLUE, GREY, RED = "#1f5fa8", "0.45", "#c0392b"


def plot(placement: "Placement", ax: "Axes | None" = None) -> "Axes":
    """Draw the ring from above: where the cameras sit, what is forbidden, where equidistant ones would sit.

    Parameters
    ----------
    placement : Placement
    ax : matplotlib.axes.Axes, optional
        Where to draw; new axes of a figure of their own by default, which `ax.figure` gives.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> import exact, trimesh
    >>> from placement import Settings, optimise
    >>> quick = Settings(n_samples=200, n_angles=12, n_starts=2, ring_cameras=8, polish_steps=())
    >>> found = optimise(trimesh.creation.box((10, 10, 9)), exact.Ring(), 2, settings=quick, certify=False)
    >>> ax = plot(found)
    >>> ax.get_title(), found._repr_html_().count("<tr>")
    ('2 cameras: 60.87 % of the ring maximum', 6)
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Arc, Circle

    if ax is None:
        ax = Figure(figsize=(4.6, 4.8), layout="constrained").subplots()
    ring = placement.ring
    radius = ring.diameter / 2
    ax.add_patch(Circle((0, 0), radius, fill=False, color="0.6", linewidth=1.2))
    for start, end in np.degrees(placement.constraints.forbidden).reshape(-1, 2):
        ax.add_patch(Arc((0, 0), 2 * radius, 2 * radius, theta1=start, theta2=end, color=RED, linewidth=5, alpha=0.5))
    even, best = ring.equidistant(placement.n_cameras), np.array(placement.angles)
    name = f"equidistant, {_percent(placement.equidistant_fraction)}"
    ax.plot(radius * np.cos(even), radius * np.sin(even), "o", mfc="white", mec=GREY, ms=10, mew=1.5, label=name)
    name = f"optimised, {_percent(placement.fraction)}"
    ax.plot(radius * np.cos(best), radius * np.sin(best), "s", color=BLUE, ms=8, label=name)
    for angle in placement.angles:
        at = (1.22 * radius * np.cos(angle), 1.22 * radius * np.sin(angle))
        ax.annotate(f"{np.degrees(angle):.1f}°", at, ha="center", va="center", fontsize=9, color=BLUE)
    limit = 1.45 * radius
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    of_cameras = f"{placement.n_cameras} camera{'' if placement.n_cameras == 1 else 's'}"
    ax.set_title(f"{of_cameras}: {_percent(placement.fraction)} of the ring maximum")
    ax.legend(loc="center", frameon=False, fontsize=9)
    return ax


def html(placement: "Placement") -> str:
    """A table of layouts and the ring from above, for notebooks."""
    phase = np.degrees(placement.best_equidistant_phase)
    most = placement.most_area
    layouts = [
        ("equidistant", placement.equidistant_area, placement.equidistant_fraction, placement.equidistant_error_rms),
        (f"equidistant, best phase ({phase:.1f}°)", placement.best_equidistant_area,
         placement.best_equidistant_fraction, placement.best_equidistant_error_rms),
        ("most area", most.area, most.fraction, placement.most_area_error_rms),
        ("optimised", placement.area, placement.fraction, placement.error_rms),
    ]  # fmt: skip
    if most.angles == placement.angles:
        del layouts[2]
    rows = [(name, f"{area:.2f}", _percent(fraction), f"{error:.4f}") for name, area, fraction, error in layouts]
    rows.append(("ring maximum", f"{placement.ring_area:.2f}", _percent(1.0), ""))
    head = ("layout", "exact area [mm²]", "of the ring maximum", f"RMS error along {placement.demand.error} [mm]")
    return page(rows_html(head, rows), plot(placement))


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.2f} %"
