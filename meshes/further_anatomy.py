"""The anatomy of sites beyond the five of Wachter 2021, from the list of procedures in its Table 1."""

from meshes.anatomy import Anatomy, Lump

# Lens and iris as a low dome with a pupil, in a shallow, wide bed; vessels of the conjunctiva around it.
EYE_ANTERIOR = Anatomy(
    bowl=2.5,
    uneven=(0.12, 9.0),
    uneven_height=5.0,
    fillet=3.0,
    vessels=(
        ((-17, 2, 0.1, 0.9), (-11, 3, 0.3, 0.8), (-8.5, 6, 0.3, 0.7), (-9, 14, 0.1, 0.6)),
        ((17, -4, 0.1, 0.9), (11, -5, 0.3, 0.8), (7, -9, 0.3, 0.7), (2, -16, 0.1, 0.6)),
        ((10, 13, 0.1, 0.7), (8.5, 7.5, 0.3, 0.6), (12, 2, 0.3, 0.6), (17, 3, 0.1, 0.5)),
    ),
    furrows=(((0, 0, 3.6, 2.2), (0, 0, 4.6, 2.4)),),
    bulges=(Lump((0, 0, -2.5), (8.5, 8.5, 5.5)),),
    top=6.5,
    seed=11,
)

# The dural sac along y with a nerve root leaving it, the disc bulging beside it, under the edge of the lamina.
SPINE_DISC = Anatomy(
    bowl=2.0,
    rise=(6.0, 3.1, 6.0, 10.0),
    flare=3.0,
    flare_height=13.0,
    uneven=(0.3, 10.0),
    vessels=(
        ((5, -18, 0.5, 4.4), (4.5, -6, 1.2, 4.6), (5, 5, 1.2, 4.5), (6, 18, 0.5, 4.2)),
        ((4, -2, 1.5, 2.2), (0, 3, 1.6, 2.0), (-5, 8, 1.0, 1.8), (-9, 16, 0.2, 1.7)),
        ((-17, -7, 0.2, 1.0), (-8, -7, 0.5, 1.0), (-3, -9, 0.6, 0.9), (2, -17, 0.3, 0.9)),
    ),
    bulges=(Lump((-6, -1, 0), (5, 6, 4)),),
    pockets=(Lump((-13, -2, 6), (5, 7, 3)),),
    top=18.0,
    seed=12,
)

# A resection cavity: lobed, wider than its opening, with bridging vessels.
GLIOBLASTOMA = Anatomy(
    bowl=11.0,
    rise=(8.0, 2.3, 10.0, 24.0),
    flare=2.5,
    flare_height=20.0,
    uneven=(1.1, 21.0),
    uneven_height=30.0,
    fillet=9.0,
    vessels=(
        ((-32, -6, 0.3, 2.0), (-19, -8, 1.0, 1.9), (-6, -3, 1.3, 1.8), (8, -6, 1.0, 1.6), (32, -14, 0.3, 1.4)),
        ((-6, -3, 1.2, 1.5), (-4, 9, 1.1, 1.4), (3, 19, 0.8, 1.3), (4, 32, 0.2, 1.2)),
        ((-26, 18, 0.2, 1.4), (-14, 12, 0.9, 1.4), (-4, 9, 1.1, 1.3)),
    ),
    furrows=(
        ((-20, -16, 0.2, 2.0), (-8, -13, 0.0, 2.2), (4, -16, 0.0, 2.0), (16, -12, 0.2, 1.8)),
        ((-12, 20, 0.2, 1.8), (6, 8, 0.0, 2.0), (19, 7, 0.2, 1.8)),
    ),
    arteries=(((-32, 6, 18, 3.0), (-16, 7, 21, 2.8), (0, 12, 23, 2.6), (14, 11, 22, 2.5), (31, 14, 18, 2.5)),),
    pockets=(Lump((25, 3, 14), (8, 11, 6)), Lump((-14, 23, 15), (11, 9, 6))),
    bulges=(Lump((-4, -29, 22), (12, 10, 8)),),
    top=36.0,
    seed=13,
)

# The cleft between cerebellum (bulge) and petrous bone, with the nerves to the inner ear and an arterial loop.
CEREBELLOPONTINE = Anatomy(
    bowl=4.0,
    rise=(12.0, 1.8, 6.0, 18.0),
    uneven=(0.4, 12.0),
    uneven_height=18.0,
    arteries=(
        ((-18, -2, 8, 2.0), (-7, -1, 10, 1.9), (3, 2, 10.5, 1.9), (18, 5, 9, 2.1)),
        ((-18, -7.5, 9, 1.7), (-7, -7, 11, 1.7), (3, -5, 11.5, 1.6), (18, -3, 10, 1.7)),
        ((-9, -18, 11, 1.8), (-5, -10, 16, 1.7), (1, -2, 18, 1.7), (7, -9, 16, 1.6), (10, -18, 11, 1.6)),
    ),
    vessels=(
        ((-17, 6, 0.2, 1.4), (-6, 5, 0.8, 1.3), (4, 8, 0.7, 1.2), (8, 18, 0.2, 1.1)),
        ((-10, -14, 0.2, 1.2), (-2, -8, 0.9, 1.2), (9, -7, 0.8, 1.1), (17, -9, 0.2, 1.0)),
    ),
    bulges=(Lump((-3, 17, 30), (11, 9, 10)),),
    pockets=(Lump((14, -5, 6), (5, 6, 3.5)),),
    top=44.0,
    seed=14,
)
