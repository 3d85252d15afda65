"""What was odd, mended, repaired and looks wrong is said at the command line, in --json and in layout.json."""

import json

import numpy as np
import pytest
import shapely
import trimesh

import meshes
from meshes.condition.overlapping import overlapping
from tests.meshes.defects import bowl, mesh_of, sheet


def saved(folder, mesh, name="scan.ply"):
    path = folder / name
    path.write_bytes(mesh.export(file_type="ply"))
    return path


def evaluated(camring, path, *options):
    status, out, err = camring("evaluate", path, "--cameras", 2, "--json", *options)
    return status, json.loads(out) if out else None, " ".join(err.split())


def test_what_was_mended(camring, tmp_path):
    mesh = bowl()
    path = saved(tmp_path, mesh_of(mesh.vertices, np.vstack([mesh.faces, [[0, 0, 1]], mesh.faces[:2]])))
    status, found, err = evaluated(camring, path)
    assert status == 0
    notes = ["left out 1 face of zero area", "left out 2 faces that repeated another"]
    assert found["mesh"]["notes"] == notes and found["mesh"]["repairs"] == found["mesh"]["warnings"] == []
    assert f"note: {path}: {'; '.join(notes)}" in err


def test_what_a_repair_did(camring, tmp_path, quick_search):
    mesh = bowl()
    mesh.invert()
    path = saved(tmp_path, mesh)
    status, _, err = evaluated(camring, path)
    assert status == 2 and "--repair turns it outside-out" in err and "repair=True" not in err
    status, found, err = evaluated(camring, path, "--repair")
    assert status == 0 and found["mesh"]["repairs"] == ["turned 1 body outside-out"] and found["mesh"]["repair"]
    assert f"repaired: {path}: turned 1 body outside-out" in err
    rig = tmp_path / "rig.toml"
    rig.write_text("[cameras]\ncount = 2\n" + quick_search, encoding="utf-8")
    out = tmp_path / "out"
    assert camring("optimise", path, "--rig", rig, "--repair", "--out", out)[0] == 0
    layout = json.loads((out / "layout.json").read_text(encoding="utf-8"))
    for one in (layout["mesh"], *layout["meshes"]):
        assert one["repairs"] == ["turned 1 body outside-out"] and one["repair"] and not one["two_sided"]
    # What reads the layout repairs the mesh as it was.
    assert camring("report", out, "--mesh", path, "--out", tmp_path / "page")[0] == 0
    glb = ("export", out / "layout.json", "--format", "glb", "--mesh", path, "--out", tmp_path / "glb")
    assert camring(*glb)[0] == 0 and camring(*glb, "--force", "--no-repair")[0] == 2
    made = out / "layout.json"
    for more in ((), ("--repair",)):
        status, out_text, _ = camring("evaluate", path, "--layout", made, "--json", *more)
        assert status == 0 and json.loads(out_text)["area_mm2"] == pytest.approx(layout["areas_mm2"]["optimised"])
    assert camring("evaluate", path, "--layout", made, "--no-repair")[0] == 2
    other = tmp_path / "other.json"
    other.write_bytes(made.read_bytes())
    status, out_text, _ = camring("compare", made, other, "--mesh", path, "--json")
    assert status == 0 and json.loads(out_text)["mesh"]["repairs"] == ["turned 1 body outside-out"]


def test_a_sheet_that_looks_away(camring, tmp_path):
    right = evaluated(camring, saved(tmp_path, sheet(), "right.ply"))[1]["area_mm2"]
    mesh = sheet()
    mesh.invert()
    path = saved(tmp_path, mesh)
    status, _, err = evaluated(camring, path)
    assert status == 2 and "100.0 % of what faces the cameras is its back: --repair turns" in err
    for option, told in (("--repair", "repairs"), ("--two-sided", "notes")):
        status, found, err = evaluated(camring, path, option)
        assert status == 0 and found["area_mm2"] == pytest.approx(right, rel=1e-9)
        assert found["mesh"][told] and not found["mesh"]["warnings"]


def test_half_of_it_looks_away(camring, tmp_path):
    """Two sheets side by side, one of them the wrong way round."""
    one, other = sheet(), sheet()
    for mesh, x in ((one, -9), (other, 9)):
        mesh.apply_scale(0.7).apply_translation((0.8 * x, 0, 0))
    right = evaluated(camring, saved(tmp_path, trimesh.util.concatenate([one, other]), "right.ply"))[1]["area_mm2"]
    other.invert()
    path = saved(tmp_path, trimesh.util.concatenate([one, other]))
    status, found, err = evaluated(camring, path)
    assert status == 0 and found["area_mm2"] < 0.6 * right
    (warning,) = found["mesh"]["warnings"]
    assert "is its back" in warning and "--repair" in warning and warning in err
    assert evaluated(camring, path, "--repair")[1]["area_mm2"] == pytest.approx(right, rel=1e-9)
    assert evaluated(camring, path, "--two-sided")[1]["area_mm2"] == pytest.approx(right, rel=1e-9)


def test_mixed_winding_that_nobody_sees_stops_no_one(camring, tmp_path):
    block = trimesh.creation.box((20, 20, 8)).subdivide().subdivide()
    right = evaluated(camring, saved(tmp_path, block, "right.ply"))[1]["area_mm2"]
    below = np.flatnonzero(block.triangles_center[:, 2] < -3.9)[:5]
    faces = block.faces.copy()
    faces[below] = faces[below, ::-1]
    status, found, _ = evaluated(camring, saved(tmp_path, mesh_of(block.vertices, faces)))
    assert status == 0 and found["area_mm2"] == pytest.approx(right, rel=1e-9)
    assert found["mesh"]["notes"] == ["turned 5 faces round to wind all alike, which nobody sees"]
    with pytest.raises(meshes.MeshError, match="wound in opposite senses"):
        meshes.load(tmp_path / "scan.ply")  # the library knows of no cameras


def test_little_in_view(camring, tmp_path):
    wide = sheet()
    wide.apply_scale((40, 40, 1))
    status, found, err = evaluated(camring, saved(tmp_path, wide))
    (warning,) = found["mesh"]["warnings"]
    assert status == 0 and "of its surface is in view" in warning and "--scale" in warning and warning in err


def test_faces_on_top_of_others(camring, tmp_path):
    """Two bodies that are flush count twice where both are; what touches another, or looks the other way, does not."""
    low = trimesh.creation.box(bounds=[[-5, -5, -3], [3, 5, 0]])
    high = trimesh.creation.box(bounds=[[-2, -4, -4], [6, 4, 0]])
    path = saved(tmp_path, trimesh.util.concatenate([low, high]))
    status, found, err = evaluated(camring, path)
    (warning,) = found["mesh"]["warnings"]
    assert status == 0 and "lie on top of others" in warning and "z 0 mm" in warning and warning in err
    assert found["area_mm2"] == pytest.approx(80 + 64)  # of 104
    status, out, _ = camring("check", path, "--json")
    content = json.loads(out)
    assert status == 0 and content["n_overlapping"] >= 2 and content["overlapping"] in warning
    assert "lie on top of others" in " ".join(camring("check", path)[1].replace("│", " ").split())
    high.apply_translation((0, 0, 4))
    assert not meshes.inspect(trimesh.util.concatenate([low, high])).overlapping


@pytest.mark.parametrize("seed", range(5))
def test_which_faces_lie_on_top_of_others(seed):
    """Triangles in two planes that cut each other, against the areas that polygons share."""
    rng = np.random.default_rng(seed)
    flat = rng.uniform(-10, 10, (30, 3, 2))
    turned = np.linalg.det(np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=1)) < 0
    flat[turned] = flat[turned, ::-1]
    flat[::4] = flat[::4, ::-1]  # these look the other way
    plane = np.arange(30) % 2
    points = np.concatenate([flat, np.where(plane, 0.0, 3.0)[:, None, None] * np.ones((30, 3, 1))], axis=2)
    mesh = mesh_of(points.reshape(-1, 3), np.arange(90).reshape(-1, 3))
    mesh.apply_transform(trimesh.transformations.random_rotation_matrix(rng.random(3)))
    kind = 2 * plane + (np.arange(30) % 4 == 0)
    shapes = shapely.polygons(flat)
    shared = shapely.area(shapely.intersection(shapes[:, None], shapes[None])) * (kind[:, None] == kind[None])
    np.fill_diagonal(shared, 0.0)
    found = overlapping(mesh.vertices, mesh.faces)
    assert (shared[found.pairs[:, 0], found.pairs[:, 1]] > 0).all()
    # Of each pair that shares much, one at least is found on another.
    much = np.argwhere(shared > 0.3 * np.minimum(*np.meshgrid(shapely.area(shapes), shapely.area(shapes))))
    assert len(much) and all(np.isin(pair, found.pairs).any() for pair in much)


def test_a_sheet_with_both_sides_whatever_their_order(tmp_path):
    mesh = sheet()
    both = np.concatenate([mesh.faces, mesh.faces[:, ::-1]])
    for seed in range(5):
        path = saved(tmp_path, mesh_of(mesh.vertices, np.random.default_rng(seed).permutation(both)))
        assert len(meshes.load(path).faces) == len(both)


def test_a_sound_mesh_is_told_nothing_of(camring, tmp_path):
    path = tmp_path / "site.stl"
    path.write_bytes(meshes.stl_bytes(meshes.site("circ_artery", 50)))
    status, found, err = evaluated(camring, path)
    assert status == 0 and err == ""
    assert found["mesh"]["notes"] == found["mesh"]["repairs"] == found["mesh"]["warnings"] == []
