"""The anatomy of the five sites of Wachter 2021, shaped so that their areas come out as published."""

from meshes.anatomy import Anatomy, Lump

# x, y, height above the floor (arteries: above the focus) and radius along the axis of each tube [mm]; both ends of a
# vessel lie in the wall or in another vessel.
SMALL_VESSELS = (
    ((-15, 4, 0.2, 1.7), (-8, 3, 0.5, 1.6), (-2, 0.5, 1.0, 1.4), (4, -3, 0.8, 1.3), (14, -8, 0.3, 1.2)),
    ((-2, 0.5, 0.9, 1.3), (1, 5, 0.6, 1.1), (4, 14, 0.3, 1.0)),
    ((-13, -8, 0.2, 1.2), (-6, -6, 0.6, 1.1), (2, -8.5, 0.5, 1.0), (6, -14, 0.2, 1.0)),
)
# A thick artery across the channel and a branch beside it. Both run along x, so that the equidistant cameras on the x
# axis see under neither: on this site it matters where the cameras sit.
ARTERY = (
    ((-15, 4, 28.5, 2.1), (-7, 4, 30.5, 1.9), (0, 4, 31, 1.9), (7, 4, 30.5, 1.9), (15, 4, 28.5, 2.0)),
    (
        (-14, 3, 28.5, 1.6),
        (-9.5, 0.5, 30, 1.6),
        (-5.5, -3.8, 30.5, 1.4),
        (0, -4.5, 31, 1.4),
        (7, -4.7, 30.5, 1.4),
        (15, -4.5, 28.5, 1.4),
    ),
)
NETWORK = (
    ((-15, -3, 0.3, 1.8), (-7, -2, 0.9, 1.7), (-1, 1, 1.2, 1.6), (5, 1, 1.0, 1.6), (9, 4, 0.8, 1.5), (15, 6, 0.3, 1.4)),
    ((-1, 1, 1.1, 1.4), (-3, 6, 0.9, 1.3), (-6, 14, 0.3, 1.2)),
    ((5, 1, 1.0, 1.4), (6, -5, 0.8, 1.3), (10, -11, 0.3, 1.2)),
    ((-11, 9, 0.3, 1.2), (-4, 7, 0.9, 1.2), (3, 6, 1.3, 1.1), (8, 10, 0.4, 1.1)),
    ((-9, -11, 0.3, 1.3), (-4, -6, 0.7, 1.2), (2, -7, 1.2, 1.1), (7, -4, 0.9, 1.0), (14, -4, 0.3, 1.0)),
)
FURROWS = (
    ((-9, -7, 0.2, 1.3), (-3, -4, -0.2, 1.4), (3, -3, 0.0, 1.3), (8, -2, 0.3, 1.2)),
    ((-7, 6, 0.2, 1.2), (-1, 4, -0.1, 1.3), (4, 4, 0.0, 1.2), (9, 0, 0.2, 1.1)),
)
UNDERCUTS = (Lump((-11, 4, 8), (4.5, 6, 3)), Lump((-5, -11, 9), (6, 4, 3.5)))
LONG_NETWORK = (
    (
        (-24, -2, 0.2, 2.0),
        (-14, -3, 0.8, 1.8),
        (-5, -1, 1.1, 1.7),
        (3, 2, 1.2, 1.6),
        (11, 1, 0.9, 1.5),
        (24, 5, 0.2, 1.4),
    ),
    ((-5, -1, 1.0, 1.4), (-8, 5, 0.9, 1.3), (-10, 13, 0.2, 1.2)),
    ((3, 2, 1.1, 1.4), (6, -4, 0.9, 1.3), (14, -6, 0.7, 1.2), (20, -10, 0.2, 1.1)),
    ((-20, 6, 0.2, 1.2), (-12, 6, 0.6, 1.2), (-3, 6, 1.3, 1.1), (4, 8, 0.7, 1.1), (8, 14, 0.2, 1.0)),
    ((-16, -11, 0.2, 1.3), (-9, -6, 0.7, 1.2), (0, -6, 1.1, 1.1), (6, -13, 0.2, 1.0)),
)
LONG_FURROWS = (
    ((-17, -5, 0.3, 1.3), (-9, -3.5, 0.0, 1.4), (0, -3, -0.2, 1.3), (8, -1.5, 0.1, 1.2), (16, 0, 0.3, 1.2)),
    ((-14, 3, 0.3, 1.2), (-4, 3.5, -0.1, 1.3), (5, 5, 0.0, 1.2), (14, 4, 0.3, 1.1)),
)

PAPER_ANATOMY = {
    "circ_flat": Anatomy(bowl=4.5, uneven=(0.3, 11.0), vessels=SMALL_VESSELS, top=15.0, seed=3),
    "circ_artery": Anatomy(bowl=4.5, uneven=(0.3, 11.0), vessels=SMALL_VESSELS, arteries=ARTERY, top=15.0, seed=3),
    "circ_angled": Anatomy(
        bowl=8.0,
        rise=(26.0, 0.2, 4.0, 16.0),
        flare=3.0,
        flare_height=20.0,
        uneven=(0.4, 10.0),
        vessels=NETWORK,
        furrows=FURROWS,
        pockets=UNDERCUTS,
        top=36.0,
        seed=5,
    ),
    "circ_overhang": Anatomy(
        bowl=5.0,
        rise=(10.0, 0.2, 4.0, 16.0),
        uneven=(0.4, 10.0),
        vessels=NETWORK,
        furrows=FURROWS,
        pockets=UNDERCUTS,
        bulges=(Lump((4, -13, 23), (8, 8, 7)),),
        top=36.0,
        seed=5,
    ),
    "elliptical": Anatomy(
        bowl=6.0,
        rise=(12.0, 0.2, 10.0, 16.0),
        uneven=(0.4, 10.0),
        vessels=LONG_NETWORK,
        furrows=LONG_FURROWS,
        pockets=(Lump((-16, 5, 10), (7, 6, 4)), Lump((-6, -10, 9), (8, 5, 3.5)), Lump((9, 10, 15), (7, 4, 4))),
        bulges=(Lump((20, -8, 24), (6, 5, 5)),),
        top=36.0,
        seed=7,
    ),
}
