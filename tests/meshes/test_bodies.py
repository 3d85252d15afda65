"""Closed bodies inside-out: a hollow where there is solid around it, a fault where there is not."""

import numpy as np
import pytest
import trimesh

import exact
import meshes
from tests.support.scenes import together

SITE = meshes.site("circ_flat", depth=50)  # a block of 60 x 60 mm with a channel of radius 12.5 mm along z
RING = exact.Ring()


def box(size, at=(0.0, 0.0, 0.0)):
    return trimesh.creation.box(np.broadcast_to(size, 3)).apply_translation(at)


def inside_out(mesh):
    mesh = mesh.copy()
    mesh.invert()
    return mesh


def tilted(mesh):
    """As it is rarely along the axes."""
    return mesh.copy().apply_transform(trimesh.transformations.rotation_matrix(0.3, (1, 2, 0.5)))


def without_bottom(mesh):
    """The block, open below."""
    below = mesh.triangles[:, :, 2].max(axis=1) <= mesh.bounds[0, 2]
    return trimesh.Trimesh(mesh.vertices, mesh.faces[~below], process=False)


INSTRUMENTS = {
    "held in the channel": box((4, 4, 30), (1, -2, 25)),
    "held out of the channel": box((4, 4, 60), (1, -2, 45)),
    "lying on the channel's floor": box((6, 8, 5), (1, -2, 2.5 + 1.25)),
    "round": trimesh.creation.cylinder(2.0, 40.0, sections=64).apply_translation((3, 3, 40)),
    "pressed a little into the wall": box((5, 4, 30), (10.5, 0, 30)),
}
floor = SITE.triangles_center[np.hypot(*SITE.triangles_center[:, :2].T) < 5][:, 2].min()
INSTRUMENTS["lying on the channel's floor"].apply_translation((0, 0, floor - 1.25))


@pytest.mark.parametrize("site", [SITE, tilted(SITE), without_bottom(SITE)], ids=["block", "tilted", "open below"])
@pytest.mark.parametrize("name", INSTRUMENTS)
def test_an_instrument_in_the_channel_is_no_hollow(name, site):
    rod = tilted(INSTRUMENTS[name]) if site.bounds[0, 2] < -13 else INSTRUMENTS[name]
    for parts in ((site, inside_out(rod)), (inside_out(rod), site)):
        with pytest.raises(meshes.MeshError, match=rf"closed, but inside-out \(its volume is -{rod.volume:.4g}"):
            meshes.check(together(*parts))
        repaired = meshes.check(together(*parts), repair=True)
        assert repaired.metadata["repairs"] == ["turned 1 body outside-out"]
        assert repaired.volume == pytest.approx(site.volume + rod.volume)
    meshes.check(together(site, rod))


def test_no_area_of_an_instrument_is_lost():
    rod = INSTRUMENTS["held in the channel"]
    cameras = RING.cameras(RING.equidistant(4))
    seen = [
        exact.evaluate(meshes.check(together(SITE, one), repair=True), cameras, threshold=1)
        .face_areas[len(SITE.faces) :]
        .sum()
        for one in (rod, inside_out(rod))
    ]
    assert seen[1] == pytest.approx(seen[0], rel=1e-12) and seen[0] > 16  # more than its upper end


@pytest.mark.parametrize("site", [SITE, tilted(SITE), without_bottom(SITE)], ids=["block", "tilted", "open below"])
@pytest.mark.parametrize("size", [0.01, 3.0])
def test_a_hollow_in_the_tissue_stays(site, size):
    hollow = box(size, (25, 20, 20))
    hollow = tilted(hollow) if site.bounds[0, 2] < -13 else hollow
    for parts in ((site, inside_out(hollow)), (inside_out(hollow), site)):
        both = together(*parts)
        assert meshes.check(both) is both


def test_hollows_in_solids_in_hollows():
    nested = together(
        inside_out(box(2)), box(8), inside_out(box(6)), box(4), inside_out(box(1, (50, 0, 0))), box(3, (50, 0, 0))
    )
    assert meshes.check(nested) is nested
    far = nested.copy().apply_translation((1e6, 0, 0))
    assert meshes.check(far) is far


def test_a_body_in_a_hollow_is_no_hollow_itself():
    """Whatever its bounding box lies in, around it is air."""
    wrong = together(box(8), inside_out(box(6)), inside_out(box(4)))
    with pytest.raises(meshes.MeshError, match=r"its volume is -64\)"):
        meshes.check(wrong)
    repaired = meshes.check(wrong, repair=True)
    assert repaired.volume == pytest.approx(8**3 - 6**3 + 4**3)
    hollow_in_it = meshes.check(together(wrong, inside_out(box(2))), repair=True)
    assert hollow_in_it.metadata["repairs"] == ["turned 1 body outside-out"]
    assert hollow_in_it.volume == pytest.approx(8**3 - 6**3 + 4**3 - 2**3)


def test_beside_each_other_all_are_turned():
    rods = [box((2, 2, 9), (x, 0, 20)) for x in (-6, 0, 6)]
    repaired = meshes.check(together(SITE, *map(inside_out, rods)), repair=True)
    assert repaired.metadata["repairs"] == ["turned 3 bodies outside-out"]
    assert repaired.volume == pytest.approx(SITE.volume + 3 * 36)
