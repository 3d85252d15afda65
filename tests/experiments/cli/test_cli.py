"""The command line: what it prints, what it writes, what it refuses."""

import csv
import json
import re

import matplotlib.image
import numpy as np
import pytest
import trimesh

import exact
import meshes
from experiments.cli.app import main


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """A file that is not built in, with a blank and a non-Latin letter in its name."""
    step = trimesh.boolean.union(
        [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))], engine="manifold"
    )
    path = tmp_path_factory.mktemp("scans") / "my scán.stl"
    step.export(path)
    return path


@pytest.fixture(scope="module")
def optimised(tmp_path_factory, scan):
    """The folder of one optimisation of the scan, for all tests that look at it."""
    out = tmp_path_factory.mktemp("optimised")
    with pytest.raises(SystemExit) as end:
        main(["optimise", str(scan), "--cameras", "3", "--min-separation", "6", "--out", str(out)])
    assert not end.value.code
    return out


def test_optimise_writes_layout_table_and_picture(optimised, scan):
    content = json.loads((optimised / "layout.json").read_text(encoding="utf-8"))
    mesh = meshes.load(scan)
    ring = exact.Ring()
    area = exact.evaluate(mesh, ring.cameras(content["angles_rad"]), threshold=2).area
    assert content["areas_mm2"]["optimised"] == pytest.approx(area, rel=1e-12)
    assert content["most_area"]["area_mm2"] >= content["areas_mm2"]["best_equidistant"]
    assert content["angles_deg"] == pytest.approx(np.degrees(content["angles_rad"]))
    assert content["smallest_separation_mm"] >= 6
    assert content["mesh"]["sha256"] == meshes.fingerprint(mesh)
    assert {"seed", "settings", "constraints", "versions", "ring", "threshold"} <= set(content)
    assert {"camring", "shapely", "jax", "optimistix"} <= set(content["versions"])
    of_ring = exact.gradient(mesh, ring.cameras(content["angles_rad"])).on_ring(ring)
    along = [row["along_ring_mm2_per_deg"] for row in content["mounting"]]
    assert along == pytest.approx(np.radians(of_ring.angle).tolist(), rel=1e-9, abs=1e-9)

    with (optimised / "layouts.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = [row["layout"].split(",")[0] for row in rows]
    assert names[:2] == ["equidistant"] * 2 and names[2:] in (["optimised"], ["most area", "optimised"])
    assert float(rows[-1]["area_mm2"]) == content["areas_mm2"]["optimised"]
    assert float(rows[2]["gain_fraction"]) == pytest.approx(
        (float(rows[2]["area_mm2"]) - float(rows[0]["area_mm2"])) / content["areas_mm2"]["ring_maximum"]
    )
    # 3 cameras 120 degrees apart subtend 2 asin(26 / 2 / 400.3) at the focus, more where the scan is nearer.
    assert 3.7 < float(rows[0]["widest_triangulation_angle_deg"]) < 4.0

    picture = matplotlib.image.imread(optimised / "coverage.png")
    assert picture.shape[0] > 600
    assert picture.shape[1] > 1200
    assert len(np.unique((picture[..., :3] * 255).astype(int).reshape(-1, 3), axis=0)) > 50
    assert sorted(file.name for file in optimised.iterdir()) == ["coverage.png", "layout.json", "layouts.csv"]


def test_evaluate_a_layout_prints_and_writes_areas(camring, optimised, scan, tmp_path):
    status, out, _ = camring("evaluate", scan, "--layout", optimised / "layout.json", "--out", tmp_path / "areas")
    assert status == 0
    content = json.loads((optimised / "layout.json").read_text(encoding="utf-8"))
    assert f"reconstructable area: {content['areas_mm2']['optimised']:.4f} mm²" in out
    written = json.loads((tmp_path / "areas" / "evaluation.json").read_text(encoding="utf-8"))
    assert len(written["level_areas_mm2"]) == 2
    assert len(written["camera_areas_mm2"]) == 3
    assert written["level_areas_mm2"][0] >= max(written["camera_areas_mm2"])
    for name in ("reconstructable.stl", "reconstructable.ply"):
        part = trimesh.load_mesh(tmp_path / "areas" / name)
        assert part.area == pytest.approx(written["area_mm2"], rel=1e-5)


def test_evaluate_angles_equals_the_library(camring, scan):
    status, out, _ = camring("evaluate", scan, "--angles-deg", "0,90,180", "--fov", "40x30", "--threshold", "3")
    ring = exact.Ring(fov=(40, 30))
    expected = exact.evaluate(meshes.load(scan), ring.cameras(np.radians([0, 90, 180])), threshold=3)
    assert status == 0
    assert f"reconstructable area: {expected.area:.4f} mm²" in out
    for area in expected.level_areas:
        assert f"{area:.4f}" in out


def test_evaluate_excludes_listed_faces(camring, scan, tmp_path):
    mesh = meshes.load(scan)
    listed = np.flatnonzero(meshes.top_surface(mesh))
    (tmp_path / "faces.txt").write_text("\n".join(map(str, listed)), encoding="utf-8")
    by_list = camring("evaluate", scan, "--cameras", "4", "--exclude", tmp_path / "faces.txt")[1]
    by_name = camring("evaluate", scan, "--cameras", "4", "--exclude", "top")[1]
    assert by_list.splitlines()[-1] == by_name.splitlines()[-1]
    assert by_name.splitlines()[-1] != camring("evaluate", scan, "--cameras", "4")[1].splitlines()[-1]


def test_listed_faces_count_as_in_the_file_whatever_a_repair_removes(camring, tmp_path):
    """Two plates of 50 mm², one of them listed; before each there is a face that the repair removes."""
    corners = np.array([[-5, 0, 0], [5, 0, 0], [5, 5, 0], [-5, 5, 0], [-5, -5, 0], [5, -5, 0]], dtype=float)
    faces = [[0, 0, 1], [0, 1, 2], [0, 2, 3], [1, 2, 0], [4, 5, 1], [4, 1, 0]]
    trimesh.Trimesh(corners, faces, process=False).export(tmp_path / "plates.stl")
    (tmp_path / "faces.txt").write_text("4\n5\n", encoding="utf-8")
    asked = ("evaluate", tmp_path / "plates.stl", "--cameras", 4, "--repair", "--exclude", tmp_path / "faces.txt")
    status, out, _ = camring(*asked, "--json")
    found = json.loads(out)
    assert status == 0 and found["level_areas_mm2"] == pytest.approx([50.0, 50.0], rel=1e-12)
    assert "2 faces listed" in found["mesh"]["excluded"] and "50.00 mm²" in found["mesh"]["excluded"]
    (tmp_path / "faces.txt").write_text("0 3", encoding="utf-8")  # of those that are removed
    assert json.loads(camring(*asked, "--json")[1])["level_areas_mm2"] == pytest.approx([100.0, 100.0], rel=1e-12)
    (tmp_path / "faces.txt").write_text("6", encoding="utf-8")
    status, _, err = camring(*asked)
    assert status == 2 and "holds '6'; each line must be a face index from 0 to 5 for this mesh" in err


def test_compare_scores_layouts_on_one_mesh(camring, optimised, scan, tmp_path):
    content = json.loads((optimised / "layout.json").read_text(encoding="utf-8"))
    by_hand = {key: content[key] for key in ("format", "version", "ring")} | {"angles_deg": [120, 240, 360]}
    (tmp_path / "mine.json").write_text(json.dumps(by_hand), encoding="utf-8")
    arguments = ("compare", tmp_path / "mine.json", optimised / "layout.json", "--mesh", scan)
    status, out, _ = camring(*arguments, "--out", tmp_path / "compared")
    assert status == 0
    assert f"{content['areas_mm2']['equidistant']:.2f}" in out
    assert f"{content['areas_mm2']['optimised']:.2f}" in out
    assert (tmp_path / "compared" / "coverage.png").stat().st_size > 20_000
    assert len((tmp_path / "compared" / "layouts.csv").read_text(encoding="utf-8").splitlines()) == 3


def test_site_writes_what_the_library_builds(camring, tmp_path):
    status, out, _ = camring("site", "circ_flat", "--depth", "100", "--out", tmp_path / "flat.stl")
    assert status == 0
    assert "circ_flat, depth 100 mm" in out
    written = meshes.load(tmp_path / "flat.stl")
    assert written.area == pytest.approx(meshes.site("circ_flat", depth=100).area, rel=1e-6)
    listing = camring("site", "--list")[1]
    assert all(name in listing for name in meshes.SITES)


def test_the_ring_looks_where_it_is_told_to(camring, scan, tmp_path):
    mesh = meshes.load(scan)
    mesh.apply_translation([310.0, -120.0, 8.5])
    mesh.export(tmp_path / "elsewhere.stl")
    _, _, err = camring("evaluate", tmp_path / "elsewhere.stl", "--cameras", "3")
    assert "it spans x 295 to 325, y -135 to -105, z -1.5 to 18.5 mm, and --focus says" in " ".join(err.split())
    area = json.loads(camring("evaluate", scan, "--cameras", "3", "--json")[1])["area_mm2"]
    focus = ("--focus", "310,-120, 8.5", "--json")
    moved = json.loads(camring("evaluate", tmp_path / "elsewhere.stl", "--cameras", "3", *focus)[1])
    assert moved["ring"]["focus_mm"] == [310.0, -120.0, 8.5]
    assert moved["area_mm2"] == pytest.approx(area, rel=1e-5)
    status, _, err = camring("evaluate", scan, "--cameras", "3", "--focus", "1,2")
    assert status == 2 and "--focus is '1,2'; it must be three numbers x,y,z in millimetres" in err


def test_nothing_is_replaced_without_force(camring, scan, tmp_path):
    out = tmp_path / "flat.stl"
    out.write_text("precious", encoding="utf-8")
    status, _, err = camring("site", "circ_flat", "--out", out)
    assert status == 2
    assert "already holds flat.stl" in err
    assert out.read_text(encoding="utf-8") == "precious"
    assert camring("site", "circ_flat", "--out", out, "--force")[0] == 0
    assert camring("evaluate", scan, "--cameras", "2", "--out", tmp_path / "a")[0] == 0
    status, _, err = camring("evaluate", scan, "--cameras", "2", "--out", tmp_path / "a")
    assert status == 2
    assert "--force" in err


def test_results_for_machines_are_all_of_stdout(camring, scan, tmp_path, monkeypatch):
    from experiments.bench import exact_areas as bench_exact
    from experiments.bench import sites as bench_sites

    _, out, err = camring("evaluate", scan, "--cameras", "4", "--json", "--out", tmp_path / "areas")
    assert json.loads(out) == json.loads((tmp_path / "areas" / "evaluation.json").read_text(encoding="utf-8"))
    assert "wrote" in err
    sites = json.loads(camring("site", "--list", "--json")[1])["sites"]
    assert {site["name"]: (tuple(site["depths_mm"]), tuple(site["fov_mm"])) for site in sites} == {
        site.name: (site.depths, site.fov) for site in meshes.SITES.values()
    }
    written = json.loads(camring("site", "circ_flat", "--out", tmp_path / "flat.stl", "--json")[1])
    assert written["files"] == [str(tmp_path / "flat.stl")]
    assert written["n_faces"] == len(meshes.load(tmp_path / "flat.stl").faces)
    assert json.loads(camring("rig", "init", tmp_path / "rig.toml", "--json")[1]) == {
        "files": [str(tmp_path / "rig.toml")]
    }
    monkeypatch.setattr(bench_exact, "MEASUREMENTS", (lambda: [("what it takes", "0.25", "s", "at most 0.3")],))
    monkeypatch.setattr(bench_exact.MEASUREMENTS[0], "__name__", "_quick")
    figures = json.loads(camring("bench", "exact", "--json", "--out", tmp_path / "exact")[1])["figures"]
    assert figures == [{"what": "what it takes", "value": "0.25", "unit": "s", "target": "at most 0.3"}]
    row = bench_sites.Row("circ_flat", 50, "36x24", "A_r(2) / A_r(360)", 0.5, 0.52, 0.06)
    monkeypatch.setattr(bench_sites, "compare", lambda *case: [row])
    figures = json.loads(camring("bench", "sites", "--json", "--out", tmp_path / "sites")[1])["figures"]
    assert figures[0]["holds"] and figures[0]["published"] == 0.52


def test_a_missed_target_is_told_by_the_exit_status(camring, scan):
    ring, mesh = exact.Ring(), meshes.load(scan)
    two, most = (exact.evaluate(mesh, ring.cameras(ring.equidistant(n))).area for n in (2, 360))
    assert two / most < 0.95
    status, out, err = camring("evaluate", scan, "--cameras", 2, "--target", f"{two / most + 0.01:.4f}")
    assert status == 1
    assert f"reconstructable area: {two:.4f} mm²" in out
    assert f"target missed: these 2 cameras reach {two / most:.4f} of the ring maximum" in " ".join(err.split())
    status, out, err = camring("evaluate", scan, "--cameras", 2, "--target", f"{two / most - 0.01:.4f}", "--json")
    assert (status, "missed" in err) == (0, False)
    assert json.loads(out)["fraction_of_ring_maximum"] == pytest.approx(two / most)
    assert json.loads(out)["ring_maximum_mm2"] == pytest.approx(most)


def test_a_fault_of_camring_is_told_from_a_missed_target(camring, monkeypatch):
    def broken(*_):
        raise RuntimeError("not thought of")

    monkeypatch.setattr("experiments.cli.commands.site.run", broken)
    status, out, err = camring("site", "--list")
    assert (status, out) == (70, "")
    assert "Traceback" in err and "RuntimeError: not thought of" in err


def test_a_file_in_metres_is_noticed(camring, scan, tmp_path):
    small = tmp_path / "metres.stl"
    meshes.load(scan).apply_scale(0.001).export(small)
    _, _, err = camring("evaluate", small, "--cameras", 2)
    assert re.search(
        r"warning: .*metres\.stl: the largest side is 0\.03 mm.*metres.*--scale 1000", " ".join(err.split())
    )
    status, scaled, err = camring("evaluate", small, "--cameras", 2, "--scale", 1000)
    assert (status, "warning" in err) == (0, False)
    area = exact.evaluate(meshes.load(scan), exact.Ring().cameras([np.pi, 2 * np.pi])).area
    found = re.search(r"reconstructable area: ([\d.]+) mm²", scaled)
    assert found is not None
    assert float(found[1]) == pytest.approx(area, rel=1e-5)  # STL files hold single precision


def test_a_rig_file_gives_the_number_of_cameras_to_evaluate(camring, scan, tmp_path):
    rig = text(tmp_path, "rig.toml", "[cameras]\ncount = 3\nthreshold = 3\n[constraints]\nmin_baseline = 20\n")
    content = json.loads(camring("evaluate", scan, "--rig", rig, "--json")[1])
    ring = exact.Ring()
    area = exact.evaluate(meshes.load(scan), ring.cameras(ring.equidistant(3)), threshold=3, min_baseline=20.0).area
    assert content["area_mm2"] == pytest.approx(area)
    more = json.loads(camring("evaluate", scan, "--rig", rig, "--cameras", 5, "--json")[1])
    assert (len(more["angles_rad"]), more["threshold"], more["min_baseline_mm"]) == (5, 3, 20.0)
    status, _, err = camring("evaluate", scan, "--layout", write_layout(tmp_path), "--rig", rig)
    assert status == 2
    assert "a layout brings its own ring; leave --rig" in err


def test_evaluate_leaves_out_what_a_rig_file_says_of_several_meshes_and_poses(camring, scan, tmp_path):
    plain, several = tmp_path / "plain.toml", tmp_path / "several.toml"
    plain.write_text("[cameras]\ncount = 3\n", encoding="utf-8")
    several.write_text("[cameras]\ncount = 3\n[sites]\nsite_weights = [1, 2]\n[poses]\njitter = 4\n", encoding="utf-8")
    one, other = (json.loads(camring("evaluate", scan, "--rig", rig, "--json")[1]) for rig in (plain, several))
    assert one == other


def test_evaluate_weights_faces_as_a_rig_file_has_it_and_says_so(camring, scan, tmp_path):
    (tmp_path / "rig.toml").write_text("[cameras]\ncount = 3\n[sites]\nfalloff_mm = 6.0\n", encoding="utf-8")
    asked = ("evaluate", scan, "--rig", tmp_path / "rig.toml")
    mesh, ring = meshes.load(scan), exact.Ring()
    away = np.linalg.norm(mesh.triangles_center, axis=1)
    cameras = ring.cameras(ring.equidistant(3))
    expected = exact.evaluate(mesh, cameras).face_areas @ 2.0 ** -((away / 6.0) ** 2)
    assert json.loads(camring(*asked, "--json")[1])["area_mm2"] == pytest.approx(expected, rel=1e-12)
    assert "a face 6 mm from the focus counts half" in " ".join(camring(*asked)[1].split())


def write_layout(folder, **changes):
    content = {
        "format": "camring layout",
        "version": 1,
        "ring": {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]},
        "angles_deg": [0, 180],
    }
    path = folder / "layout.json"
    path.write_text(json.dumps({k: v for k, v in {**content, **changes}.items() if v is not None}), encoding="utf-8")
    return path


def text(folder, name, words):
    (folder / name).write_text(words, encoding="utf-8")
    return folder / name
