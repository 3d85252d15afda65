"""The anatomy of the five sites of Wachter 2021, shaped so that their areas come out as published."""

from meshes.anatomy import Anatomy, Lump

# x, y, z, radius along the axis of each vessel [mm]; both ends lie in the wall or in another vessel.
SMALL_VESSELS = (
    ((-15, 4, 7, 1.7), (-8, 3, 2.6, 1.6), (-2, 0.5, 1.2, 1.4), (4, -3, 1.6, 1.3), (14, -8, 7.5, 1.2)),
    ((-2, 0.5, 1.0, 1.3), (1, 5, 1.6, 1.1), (4, 14, 7, 1.0)),
    ((-13, -8, 6.5, 1.2), (-6, -6, 2.6, 1.1), (2, -8.5, 3.2, 1.0), (6, -14, 7.5, 1.0)),
)
ARTERY = (
    ((-15, -6, 28, 2.2), (-7, -3, 29.5, 2.0), (0, 0, 30, 1.9), (7, 4, 29.5, 1.8), (15, 7, 28, 1.8)),
    ((0, 0, 30, 1.4), (2, -5, 30, 1.3), (6, -10, 29, 1.2), (9, -15, 28, 1.2)),
)
# A network that climbs with the floor towards +x.
NETWORK = (
    ((-15, -3, 6, 1.8), (-7, -2, 3.5, 1.7), (-1, 1, 3.2, 1.6), (5, 1, 10, 1.6), (9, 4, 19, 1.5), (15, 6, 25, 1.4)),
    ((-1, 1, 3.2, 1.4), (-3, 6, 4.5, 1.3), (-6, 14, 8, 1.2)),
    ((5, 1, 10, 1.4), (6, -5, 12, 1.3), (10, -11, 17, 1.2)),
    ((-11, 9, 9, 1.2), (-4, 7, 6.5, 1.2), (3, 6, 10, 1.1), (8, 10, 19, 1.1)),
    ((-9, -11, 7, 1.3), (-4, -6, 4.0, 1.2), (2, -7, 7, 1.1), (7, -4, 14, 1.0), (14, -4, 24, 1.0)),
)
FURROWS = (
    ((-9, -7, 2.5, 1.3), (-3, -4, 0.8, 1.4), (3, -3, 2.5, 1.3), (8, -2, 13, 1.2)),
    ((-7, 6, 3, 1.2), (-1, 4, 1.4, 1.3), (4, 4, 6, 1.2), (9, 0, 17, 1.1)),
    ((10, -8, 20, 1.6), (12.5, 0, 26, 1.8), (10, 8, 21, 1.6)),
)
UNDERCUTS = (Lump((-11, 4, 8), (4.5, 6, 3)), Lump((-5, -11, 9), (6, 4, 3.5)))

PAPER_ANATOMY = {
    "circ_flat": Anatomy(bowl=4.5, uneven=(0.3, 11.0), vessels=SMALL_VESSELS, top=15.0, seed=3),
    "circ_artery": Anatomy(bowl=4.5, uneven=(0.3, 11.0), vessels=SMALL_VESSELS + ARTERY, top=36.0, seed=3),
    "circ_angled": Anatomy(
        bowl=4.0,
        rise=(24.0, 0.2, 5.0, 16.0),
        uneven=(0.4, 10.0),
        vessels=NETWORK,
        furrows=FURROWS,
        pockets=UNDERCUTS,
        top=36.0,
        seed=5,
    ),
    "circ_overhang": Anatomy(
        bowl=4.0,
        rise=(15.0, 0.2, 5.0, 16.0),
        uneven=(0.4, 10.0),
        vessels=NETWORK,
        furrows=FURROWS,
        pockets=UNDERCUTS,
        bulges=(Lump((-12, -4, 24), (7, 8, 6)),),
        top=36.0,
        seed=5,
    ),
    "elliptical": Anatomy(
        bowl=6.0,
        rise=(12.0, 0.2, 10.0, 16.0),
        uneven=(0.4, 10.0),
        vessels=NETWORK,
        furrows=FURROWS,
        pockets=UNDERCUTS,
        top=36.0,
        seed=7,
    ),
}
