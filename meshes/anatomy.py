"""What a surgical site is made of, and the field of its air.

All lengths in millimetres; the origin is the focus, in the middle of the channel floor; +z is towards the cameras.
"""

from dataclasses import dataclass

import numpy as np

from meshes import field

Knots = tuple[tuple[float, float, float, float], ...]  # x, y, z, radius along a tube's axis


@dataclass(frozen=True)
class Opening:
    """Cross-section of the channel at the top surface.

    Attributes
    ----------
    half_axes : (2,) tuple of float
        Half the width along x and along y [mm].
    exponent : float
        Of the superellipse |x/a|^p + |y/b|^p = 1; 2 is an ellipse.
    corners : int
        Of the inscribed polygon that the opening is at the top surface, the first on +x.
    """

    half_axes: tuple[float, float]
    corners: int
    exponent: float = 2.0

    def polygon(self) -> np.ndarray:
        """(corners, 2) the exact outline of the channel, counter-clockwise [mm]."""
        angle = 2 * np.pi * np.arange(self.corners) / self.corners
        cosine, sine = np.cos(angle), np.sin(angle)
        power = 2 / self.exponent
        return np.stack(
            [
                self.half_axes[0] * np.sign(cosine) * np.abs(cosine) ** power,
                self.half_axes[1] * np.sign(sine) * np.abs(sine) ** power,
            ],
            axis=1,
        )

    def distance(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(N,) about the distance of points of the plane to the smooth curve [mm]; positive inside.

        The polygon's corners would be cut by triangles that lean by more than the angle at which cameras see a
        wall; between two of the curve's points the wall is as upright as the triangles are small.
        """
        u, v = np.abs(x) / self.half_axes[0], np.abs(y) / self.half_axes[1]
        level = (u**self.exponent + v**self.exponent) ** (1 / self.exponent)
        safe = np.where(level > 0, level, 1.0)
        slope = np.hypot(
            (u / safe) ** (self.exponent - 1) / self.half_axes[0],
            (v / safe) ** (self.exponent - 1) / self.half_axes[1],
        )
        return np.where(level > 0, (1 - level) / np.where(level > 0, slope, 1.0), min(self.half_axes))


@dataclass(frozen=True)
class Lump:
    """An ellipsoid: a bulge where it is tissue, a pocket where it is air."""

    centre: tuple[float, float, float]
    radii: tuple[float, float, float]


@dataclass(frozen=True)
class Anatomy:
    """Everything below the rim of a site; independent of the depth, which only lengthens the channel.

    Attributes
    ----------
    bowl : float
        How much higher the floor lies at the wall than in the middle [mm].
    rise : tuple of float
        How much the floor climbs towards one side [mm], the azimuth of that side [rad], and where along this
        direction the slope is steepest and how long it is [mm].
    flare : float
        By how much the channel is wider below than above, as under the edge of bone [mm].
    flare_height : float
        Height of that edge [mm].
    uneven : tuple of float
        Amplitude and wavelength of the unevenness of wall and floor [mm].
    uneven_height : float
        Height above which the wall is even [mm].
    fillet : float
        Width of the rounding where floor and wall meet [mm].
    vessels, furrows : tuple of tubes
        Tissue, and air carved into the floor; they follow the floor, and z is their height above it.
    arteries : tuple of tubes
        Tissue free in space; z is their height above the focus.
    bulges, pockets : tuple of Lump
        Tissue, and air carved into wall and floor.
    top : float
        Height below which all of this lies, but for arteries wholly above it; there the channel is plain [mm].
    seed : int
        Of the unevenness.
    """

    bowl: float = 0.0
    rise: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    flare: float = 0.0
    flare_height: float = 15.0
    uneven: tuple[float, float] = (0.0, 10.0)
    uneven_height: float = 15.0
    fillet: float = 4.0
    vessels: tuple[Knots, ...] = ()
    furrows: tuple[Knots, ...] = ()
    arteries: tuple[Knots, ...] = ()
    bulges: tuple[Lump, ...] = ()
    pockets: tuple[Lump, ...] = ()
    top: float = 35.0
    seed: int = 1


WALL_UNEVEN = 0.5  # the wall's unevenness as a part of the floor's
# Below `top` the channel narrows downwards by this slope, about 1 degree. Opposite cameras see a wall at 2 to 4
# degrees; on an upright one triangles of the coarse meshes would lean out of sight here and there.
FUNNEL = 0.02
FLARE_LENGTH = 6.0  # height over which the channel widens below `flare_height` [mm]
WALL_STRETCH = 25.0  # how much longer the unevenness of the wall is along z
SAMPLES = 6  # straight pieces of a tube between two of its knots
VESSEL_FILLET = 1.2  # rounding where a vessel lies on its bed [mm]: about what the coarse meshes can show
FURROW_FILLET = 1.5
BULGE_FILLET = 4.0


def _smooth_step(t: np.ndarray) -> np.ndarray:
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _floor_height(anatomy: Anatomy, opening: Opening, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(N,) height of the floor, 0 near the origin [mm]."""
    climb, azimuth, middle, length = anatomy.rise
    along = x * np.cos(azimuth) + y * np.sin(azimuth)
    bowl = anatomy.bowl * ((x / opening.half_axes[0]) ** 2 + (y / opening.half_axes[1]) ** 2)
    slope = climb * _smooth_step((along - middle) / length + 0.5)
    start = climb * _smooth_step(np.array(0.5 - middle / length))
    return np.minimum(bowl, 2 * anatomy.bowl) + slope - start


def air(anatomy: Anatomy, opening: Opening, points: np.ndarray) -> np.ndarray:
    """Field of the air at the bottom of a site, up to `anatomy.top`.

    Parameters
    ----------
    points : (N, 3) ndarray

    Returns
    -------
    (N,) ndarray
        Positive in the air.
    """
    x, y, z = points.T
    amplitude, wavelength = anatomy.uneven
    uneven = amplitude * field.ripple(x, y, z, wavelength, anatomy.seed)
    shaped = _smooth_step(1 - z / anatomy.uneven_height)
    # Cameras see a wall at about 2 degrees: it must be far more even along z than around, or it would hide itself.
    fluted = WALL_UNEVEN * amplitude * field.ripple(x, y, z / WALL_STRETCH, wavelength, anatomy.seed)
    widening = anatomy.flare * np.clip((anatomy.flare_height - z) / FLARE_LENGTH, 0.0, 1.0)
    wall = opening.distance(x, y) - FUNNEL * (anatomy.top - z) + shaped * fluted + widening

    floor_z = _floor_height(anatomy, opening, x, y)
    step = 0.01  # [mm], for the slope by differences
    slope_x = (_floor_height(anatomy, opening, x + step, y) - floor_z) / step
    slope_y = (_floor_height(anatomy, opening, x, y + step) - floor_z) / step
    floor = (z - floor_z) / np.sqrt(1 + slope_x**2 + slope_y**2) + uneven
    result = field.smooth_min(wall, floor, anatomy.fillet)

    for lump in anatomy.pockets:
        pocket = field.ellipsoid(points, np.array(lump.centre), np.array(lump.radii))
        result = field.smooth_max(result, -pocket, FURROW_FILLET)
    for lump in anatomy.bulges:
        bulge = field.ellipsoid(points, np.array(lump.centre), np.array(lump.radii))
        result = field.smooth_min(result, bulge + 0.5 * uneven, BULGE_FILLET)
    for knots in anatomy.furrows:
        furrow = field.tube(points, _draped(anatomy, opening, knots))
        result = field.smooth_max(result, -furrow, FURROW_FILLET)
    for knots in anatomy.vessels:
        vessel = field.tube(points, _draped(anatomy, opening, knots))
        result = field.smooth_min(result, vessel, VESSEL_FILLET)
    for curve in artery_curves(anatomy, above_top=False):
        result = field.smooth_min(result, field.tube(points, curve), VESSEL_FILLET)
    return result


def arteries(anatomy: Anatomy, points: np.ndarray) -> np.ndarray:
    """Field of what is free of the arteries above `anatomy.top`, branches joined by a fillet; for (N, 3) points."""
    result = np.full(len(points), field.FAR)
    for curve in artery_curves(anatomy, above_top=True):
        result = field.smooth_min(result, field.tube(points, curve), VESSEL_FILLET)
    return result


def artery_curves(anatomy: Anatomy, above_top: bool) -> list[np.ndarray]:
    """(K, 4) curves of the arteries above or below `anatomy.top`: x, y, z and radius along the axis [mm]."""
    curves = [field.spline(np.array(knots), SAMPLES) for knots in anatomy.arteries]
    return [curve for curve in curves if (curve[:, 2].min() > anatomy.top) == above_top]


def _draped(anatomy: Anatomy, opening: Opening, knots: Knots) -> np.ndarray:
    """(K, 4) curve of a tube whose z is its height above the floor."""
    curve = field.spline(np.array(knots), SAMPLES)
    curve[:, 2] += _floor_height(anatomy, opening, curve[:, 0], curve[:, 1])
    return curve
