"""Drawings of a report, as numbers for the templates that draw them: the ring from above, curves, a histogram."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.ticker import MaxNLocator

import exact

BLUE, GREY, ORANGE = "#1f5fa8", "#6f6f6f", "#c65b1c"
# Of several rings; the second has dashes, the third dots, for who cannot tell the colours apart.
RING_COLOURS, RING_DASHES = (BLUE, ORANGE, "#1a7f5a", "#8a3a8f"), ("", "7 4", "2 4", "9 3 2 3")
# The ring is drawn with this radius, whatever its diameter [units of the drawing].
RADIUS = 100.0
# Of more cameras, separations and angles would be written over each other.
MOST_LABELS = 16
# Size of a chart, and room for its axes' labels [units of the drawing].
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 480.0, 300.0, 62.0, 14.0, 12.0, 48.0
N_BINS = 24
# Cameras with less than this between them and the middle of their chord [rad] leave no room for words beside it.
NARROW = 0.45
# Ticks stand at multiples of these and their tenfolds.
STEPS = (1, 2, 2.5, 5, 10)


def on_ring(angle: float, radius: float = RADIUS) -> tuple[float, float]:
    """Point of the drawing, whose y points down.

    Examples
    --------
    >>> on_ring(np.pi / 2)
    (0.0, -100.0)
    """
    return round(radius * float(np.cos(angle)), 2), round(-radius * float(np.sin(angle)), 2) + 0.0


def ring_drawing(
    ring: exact.Ring,
    angles: np.ndarray,
    fixed: Sequence[float],
    forbidden: Sequence[tuple[float, float]],
    rolls: np.ndarray | None = None,
) -> dict:
    """The ring from above: cameras, separations of neighbours, forbidden arcs, equidistant cameras; angles in [rad].

    And along what the width of each image lies, unless it is along the ring for all.
    """
    theta = np.asarray(angles)
    separations = ring.separations(theta)
    labelled = len(theta) <= MOST_LABELS
    cameras = [
        {
            "number": number,
            "at": on_ring(angle),
            "label_at": _beside(angle),
            "degrees": f"{np.degrees(angle):.1f}°" if labelled else "",
            "is_fixed": any(abs(np.sin((angle - other) / 2)) < 1e-9 for other in fixed),
        }
        for number, angle in enumerate(theta.tolist(), start=1)
    ]
    order = np.argsort(np.mod(theta, 2 * np.pi)).tolist()
    neighbours = list(zip(order, order[1:] + order[:1], strict=True))[: None if len(theta) > 2 else len(theta) - 1]
    chords = []
    for i, j in neighbours:
        half = float(np.mod(theta[j] - theta[i], 2 * np.pi)) / 2
        inside = RADIUS * float(np.cos(half)) - (14 if half > NARROW else 32)
        chords.append(
            {
                "from": on_ring(float(theta[i])),
                "to": on_ring(float(theta[j])),
                "label_at": on_ring(float(theta[i]) + half, max(inside, 12.0)),
                "label": f"{separations[i, j]:.1f} mm" if labelled else "",
            }
        )
    return {
        "radius": RADIUS,
        "diameter": f"{ring.diameter:g}",
        "cameras": cameras,
        "chords": chords,
        "equidistant": [on_ring(angle) for angle in ring.equidistant(len(theta))],
        "forbidden": [_arc(start, end) for start, end in forbidden],
        "has_fixed": bool(len(fixed)),
        "widths": [] if rolls is None and ring.roll == "radial" else _widths(ring, theta, rolls),
    }


def rings_drawing(rings: Sequence[exact.Ring], ring_of: Sequence[int], angles: Sequence[float]) -> dict:
    """Several rings to scale as they lie across the axis of the first, and their cameras; angles in [rad].

    Examples
    --------
    >>> drawn = rings_drawing((exact.Ring(), exact.Ring(diameter=15.0)), [0, 1], [0.0, np.pi / 2])
    >>> [camera["at"] for camera in drawn["cameras"]], [ring["words"] for ring in drawn["rings"]]
    ([(100.0, 0.0), (0.0, -50.0)], ['ring 1: 30 mm wide at 400 mm', 'ring 2: 15 mm wide at 400 mm'])
    """
    frame, focus = rings[0].frame, np.array(rings[0].focus)
    around = np.linspace(0, 2 * np.pi, 73)
    across = [((ring.positions(around) - focus) @ frame)[:, :2] for ring in rings]
    scale = RADIUS / max(float(np.abs(line).max()) for line in across)

    def placed(points: np.ndarray) -> list[tuple[float, float]]:
        return [(round(scale * x, 2), round(-scale * y, 2) + 0.0) for x, y in points.tolist()]

    cameras = []
    for number, (k, angle) in enumerate(zip(ring_of, angles, strict=True), start=1):
        at = ((rings[k].positions([angle]) - focus) @ frame)[:, :2]
        outwards = at[0] / max(float(np.linalg.norm(at)), 1e-12)
        cameras.append(
            {
                "number": number,
                "at": placed(at)[0],
                "label_at": placed(at + outwards * 24 / scale)[0],
                "degrees": f"{np.degrees(angle):.1f}°" if len(angles) <= MOST_LABELS else "",
                "colour": RING_COLOURS[k % len(RING_COLOURS)],
            }
        )
    return {
        "cameras": cameras,
        "rings": [
            {
                "line": " ".join(f"{x},{y}" for x, y in placed(line)),
                "colour": RING_COLOURS[k % len(RING_COLOURS)],
                "dash": RING_DASHES[k % len(RING_DASHES)],
                "words": f"ring {k + 1}: {ring.diameter:g} mm wide at {ring.working_distance:g} mm",
            }
            for k, (ring, line) in enumerate(zip(rings, across, strict=True))
        ],
    }


def _widths(ring: exact.Ring, angles: np.ndarray, rolls: np.ndarray | None) -> list[tuple[float, float, float, float]]:
    """Ends of a line through each camera along the width of its image."""
    found = []
    for angle, camera in zip(angles.tolist(), ring.cameras(angles, rolls), strict=True):
        (x, y), (dx, dy, _) = on_ring(angle), 24 * camera.rotation[0] @ ring.frame
        found.append((round(x - dx, 2), round(y + dy, 2), round(x + dx, 2), round(y - dy, 2)))
    return found


def _beside(angle: float) -> tuple[float, float]:
    """Middle of a label outside the ring; it is wider than high, so that it needs more room left and right."""
    x, y = on_ring(angle, 1.24 * RADIUS)
    return round(1.1 * x, 2), y


def _arc(start: float, end: float) -> str:
    """Path of a band along the ring, counter-clockwise from `start` to `end` [rad]."""
    (x0, y0), (x1, y1) = on_ring(start), on_ring(end)
    long = int(np.mod(end - start, 2 * np.pi) > np.pi)
    return f"M {x0} {y0} A {RADIUS} {RADIUS} 0 {long} 0 {x1} {y1}"


@dataclass(frozen=True)
class Series:
    """One line of a chart.

    Attributes
    ----------
    label, colour : str
    points : (N, 2) ndarray
        Not finite where there is no value.
    dash : str
        As in SVG; empty for a line without gaps.
    fill : bool
        Whether to fill what is below it.
    marks : bool
        Whether to mark its points.
    joined : bool
        Whether to draw a line from each to the next.
    """

    label: str
    colour: str
    points: np.ndarray = field(compare=False)
    dash: str = ""
    fill: bool = False
    marks: bool = False
    joined: bool = True


@dataclass(frozen=True)
class Chart:
    """Limits of the axes, what stands beside them, and whether the numbers are fractions to be told in percent."""

    x: tuple[float, float]
    y: tuple[float, float]
    x_label: str
    y_label: str
    whole_x: bool = False

    def drawing(self, series: Sequence[Series]) -> dict:
        """Numbers for the template."""
        x_ticks = _within(MaxNLocator(8, integer=self.whole_x, steps=STEPS).tick_values(*self.x), self.x)
        y_ticks = _within(MaxNLocator(6, steps=STEPS).tick_values(*self.y), self.y)
        return {
            "size": (WIDTH, HEIGHT),
            "frame": (LEFT, TOP, WIDTH - RIGHT, HEIGHT - BOTTOM),
            "x_label": self.x_label,
            "y_label": self.y_label,
            "x_ticks": [(self._place(tick, self.y[0])[0], f"{tick:g}") for tick in x_ticks],
            "y_ticks": [(self._place(self.x[0], tick)[1], f"{100 * tick:.4g} %") for tick in y_ticks],
            "series": [self._series(one) for one in series],
        }

    def _series(self, one: Series) -> dict:
        kept = one.points[np.isfinite(one.points).all(axis=1)]
        places = [self._place(x, y) for x, y in kept.tolist()]
        return {
            "label": one.label,
            "colour": one.colour,
            "dash": one.dash,
            "fill": one.fill,
            "line": " ".join(f"{x},{y}" for x, y in places) if one.joined else "",
            "marks": places if one.marks else [],
        }

    def _place(self, x: float, y: float) -> tuple[float, float]:
        across, up = (x - self.x[0]) / (self.x[1] - self.x[0]), (y - self.y[0]) / (self.y[1] - self.y[0])
        return (
            round(LEFT + across * (WIDTH - LEFT - RIGHT), 2),
            round(HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM), 2),
        )


def _within(ticks: Sequence[float], limits: tuple[float, float]) -> list[float]:
    return [float(tick) for tick in ticks if limits[0] - 1e-12 <= tick <= limits[1] + 1e-12]


def histogram_drawing(layouts: Sequence[tuple[str, np.ndarray, np.ndarray]]) -> dict | None:
    """Triangulation angles [degrees] and weights of each layout: share of its area by angle; None if there is none.

    Examples
    --------
    >>> drawn = histogram_drawing([("one", np.array([1.0, 3.0]), np.array([1.0, 3.0]))])
    >>> len(drawn["series"]), drawn["y_ticks"][-1][1]
    (1, '60 %')
    >>> histogram_drawing([("none", np.zeros(0), np.zeros(0))]) is None
    True
    """
    if not any(len(angles) for _, angles, _ in layouts):
        return None
    widest = max(float(angles.max(initial=0.0)) for _, angles, _ in layouts)
    edges = np.linspace(0, max(widest * (1 + 1e-9), 1e-3), N_BINS + 1)
    shares = [
        np.histogram(angles, edges, weights=weights)[0] / max(weights.sum(), 1e-300) for _, angles, weights in layouts
    ]
    series = []
    for (name, _, _), share, colour in zip(layouts, shares, (GREY, BLUE), strict=False):
        steps = np.column_stack([np.repeat(edges, 2), np.concatenate([[0.0], np.repeat(share, 2), [0.0]])])
        series.append(Series(name, colour, steps, fill=True))
    highest = max(float(share.max()) for share in shares)
    chart = Chart((0.0, float(edges[-1])), (0.0, highest * 1.0001), "best triangulation angle [°]", "share of the area")
    return chart.drawing(series)


def count_drawing(rows: Sequence[dict[str, float | None]]) -> dict:
    """Area over the number of cameras, from the rows of count.csv."""
    numbers = [row["n_cameras"] for row in rows]

    def curve(name: str) -> np.ndarray:
        values = [np.nan if row[name] is None else row[name] for row in rows]
        return np.column_stack([np.array(numbers, dtype=float), np.array(values, dtype=float)])

    series = [
        Series("equidistant", GREY, curve("equidistant_fraction"), marks=True),
        Series("equidistant, best phase", GREY, curve("best_equidistant_fraction"), dash="5 4", marks=True),
        Series("optimised", BLUE, curve("optimised_fraction"), marks=True),
    ]
    bound = curve("bound_fraction")
    if np.isfinite(bound[:, 1]).any():
        series.append(Series("no layout exceeds this (on samples)", ORANGE, bound, dash="2 4", marks=True))
    lowest = min(float(np.nanmin(one.points[:, 1])) for one in series[:2])
    limits = (float(min(numbers)) - 0.5, float(max(numbers)) + 0.5)  # type: ignore[arg-type]
    floor = max(0.0, lowest - 0.08 * (1 - lowest) - 0.01)
    return Chart(limits, (floor, 1.02), "cameras on the ring", "of the ring maximum", True).drawing(series)


def tradeoff_drawing(rows: Sequence[dict]) -> dict:
    """Area over error, from the rows of tradeoff.csv."""

    def points(chosen) -> np.ndarray:
        return np.array([(row["rms_error_mm"], row["fraction_of_ring_maximum"]) for row in chosen]).reshape(-1, 2)

    best = [row for row in rows if row["undominated"]]
    series = [Series("none has both more area and less error", BLUE, points(best), marks=True)]
    for kind, colour in (("equidistant", GREY), ("opposite pairs", ORANGE)):
        of_kind = points([row for row in rows if row["layout"] == kind])
        if len(of_kind):
            series.append(Series(kind, colour, of_kind, marks=True, joined=False))
    every = points(rows)
    low, high = every.min(axis=0), every.max(axis=0)
    room = 0.06 * (high - low) + (1e-4, 0.002)
    limits = (low - room, high + room)
    x, y = ((max(0.0, float(limits[0][k])), float(limits[1][k])) for k in (0, 1))
    return Chart(x, y, "RMS error [mm]", "of the ring maximum").drawing(series)
