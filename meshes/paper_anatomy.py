"""The anatomy of the five sites of Wachter 2021, shaped so that their areas come out as published."""

from meshes.anatomy import Anatomy

# x, y, z, radius along the axis of each vessel [mm]; both ends lie in the wall.
SMALL_VESSELS = (
    ((-15, 4, 6, 1.8), (-8, 3, 2.4, 1.6), (-2, 0.5, 1.2, 1.4), (4, -3, 1.6, 1.3), (14, -8, 7, 1.2)),
    ((-2, 0.5, 1.0, 1.3), (1, 5, 1.6, 1.1), (3, 14, 6, 1.0)),
    ((-13, -8, 6, 1.2), (-6, -6, 2.6, 1.1), (2, -8.5, 3.2, 1.0), (6, -14, 7, 1.0)),
)
ARTERY = (
    ((-15, -6, 27, 2.6), (-7, -3, 29.5, 2.4), (0, 0, 30.5, 2.2), (7, 4, 29, 2.1), (15, 7, 26, 2.0)),
    ((0, 0, 30.5, 1.8), (2, -5, 30, 1.6), (6, -10, 28, 1.5), (9, -15, 27, 1.5)),
)
PAPER_ANATOMY = {
    "circ_flat": Anatomy(bowl=5.0, uneven=(0.4, 11.0), vessels=SMALL_VESSELS, top=20.0, seed=3),
    "circ_artery": Anatomy(bowl=5.0, uneven=(0.4, 11.0), vessels=SMALL_VESSELS + ARTERY, top=36.0, seed=3),
}
