"""camring ring: what stands in its table is what the library gives for each ring, and a run goes on where it ended."""

import csv
import json

import matplotlib.image
import numpy as np
import pytest
import trimesh

import exact
import meshes
from experiments.layouts.layout_file import read


@pytest.fixture(scope="module")
def desk(tmp_path_factory, quick_search):
    """A floor between two walls, of which one counts, and a rig file that makes the search quick."""
    folder = tmp_path_factory.mktemp("desk")
    parts = [((40, 40, 2), (0, 0, -1)), ((2, 40, 20), (8, 0, 10)), ((2, 40, 20), (-8, 0, 10))]
    solids = [trimesh.creation.box(size).apply_translation(at) for size, at in parts]
    trimesh.util.concatenate(solids).export(folder / "trench.stl")
    (folder / "rig.toml").write_text(quick_search, encoding="utf-8")
    (folder / "left_out.txt").write_text("\n".join(map(str, range(24, 36))), encoding="utf-8")
    return folder


def asked(desk, *options):
    return ("ring", desk / "trench.stl", "--rig", desk / "rig.toml", "--cameras", 3, *options)


@pytest.fixture(scope="module")
def swept(desk, tmp_path_factory):
    """Four rings that hold three cameras 5 mm apart, and two that do not."""
    from experiments.cli.app import main

    out = tmp_path_factory.mktemp("swept") / "out"
    arguments = asked(
        desk, "--diameter", "5,20,40", "--working-distance", "200:300:100", "--exclude", desk / "left_out.txt",
        "--out", out,
    )  # fmt: skip
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in arguments])
    assert not end.value.code
    with (out / "rings.csv").open(encoding="utf-8") as file:
        return out, arguments, list(csv.DictReader(file))


def test_each_row_is_what_the_library_gives_for_that_ring(desk, swept):
    out, _, rows = swept
    mesh, exclude = meshes.load(desk / "trench.stl"), np.isin(np.arange(36), range(24, 36))
    counted = mesh.area_faces[~exclude].sum()
    sizes = [(float(row["diameter_mm"]), float(row["working_distance_mm"])) for row in rows]
    assert sizes == [(5, 200), (20, 200), (40, 200), (5, 300), (20, 300), (40, 300)]
    for row, (diameter, distance) in zip(rows, sizes, strict=True):
        if diameter == 5:
            assert "3 cameras at 5 mm need a ring of at least 5.8 mm" in row["refused"] and not row["area_mm2"]
            continue
        ring = exact.Ring(diameter, distance)
        phase = np.radians(float(row["equidistant_phase_deg"]))
        layouts = {
            "": np.radians([float(angle) for angle in row["ring_angles_deg"].split()]),
            "equidistant_": ring.equidistant(3, phase),
        }
        maximum = exact.evaluate(mesh, ring.cameras(ring.equidistant(8)), exclude=exclude).area
        for name, angles in layouts.items():
            own = exact.evaluate(mesh, ring.cameras(angles), exclude=exclude, depth_axis=ring.axis)
            assert float(row[f"{name}area_mm2"]) == pytest.approx(own.area, rel=1e-9)
            # Errors are averaged over pieces, which another rounding of the angles cuts otherwise.
            assert float(row[f"{name}rms_error_mm"]) == pytest.approx(own.error_rms, rel=1e-7)
            assert float(row[f"{name}fraction_of_ring_maximum"]) == pytest.approx(own.area / maximum, rel=1e-9)
            assert float(row[f"{name}fraction_of_counted_area"]) == pytest.approx(own.area / counted, rel=1e-9)
        at = ring.positions(layouts[""])
        nearest = min(np.linalg.norm(at[i] - at[j]) for i in range(3) for j in range(i))
        assert float(row["smallest_separation_mm"]) == pytest.approx(nearest)
        assert float(row["separation_left_mm"]) == pytest.approx(nearest - 5)
    known = [row for row in rows if row["area_mm2"]]
    for row in known:
        beaten = any(
            float(other["area_mm2"]) > float(row["area_mm2"])
            and float(other["rms_error_mm"]) < float(row["rms_error_mm"])
            for other in known
        )
        assert beaten == (row["undominated"] == "False")


def test_layouts_and_picture(swept):
    out, _, rows = swept
    image = matplotlib.image.imread(out / "rings.png")
    assert image.shape[0] > 400 and np.ptp(image[..., :3]) > 0.5
    names = {path.stem for path in (out / "layouts").iterdir()}
    assert names == {f"d{d}_h{h}_fov36x24" for d in (20, 40) for h in (200, 300)}
    made = read(out / "layouts" / "d40_h200_fov36x24.json")
    assert made.ring == exact.Ring(40.0, 200.0)
    assert np.degrees(made.angles) == pytest.approx([float(angle) for angle in rows[2]["ring_angles_deg"].split()])


def test_a_run_that_was_stopped_goes_on(camring, swept):
    out, arguments, rows = swept
    status, _, err = camring(*arguments)
    assert status == 2 and "already holds record.json" in err
    record = json.loads((out / "record.json").read_text(encoding="utf-8"))
    assert record["tasks_found_done"] == 0 and len(record["tasks"]) == 4
    (out / "record.json").unlink()
    next((out / "tasks").iterdir()).unlink()
    status, printed, err = camring(*arguments, "--json")
    assert status == 0, err
    assert json.loads((out / "record.json").read_text(encoding="utf-8"))["tasks_found_done"] == 3
    again = json.loads(printed)["rings"]
    assert [str(row["area_mm2"] or "") for row in again] == [row["area_mm2"] for row in rows]


def test_the_ring_of_optimise_has_the_layout_of_optimise(camring, desk, tmp_path):
    request = (desk / "trench.stl", "--rig", desk / "rig.toml", "--cameras", 2, "--roll", "tangential")
    assert camring("optimise", *request, "--no-robustness", "--out", tmp_path / "one")[0] == 0
    status, out, err = camring("ring", *request, "--out", tmp_path / "rings")
    assert status == 0, err
    assert "* no other ring has both more area and less error" in out
    one, other = read(tmp_path / "one" / "layout.json"), read(tmp_path / "rings" / "layouts" / "d30_h400_fov36x24.json")
    assert one.ring == other.ring and one.angles.tolist() == other.angles.tolist()
    assert one.content["areas_mm2"] == other.content["areas_mm2"]


def test_refined_rings_have_more_area_within_the_ranges(camring, desk, tmp_path):
    out = tmp_path / "rings"
    status, printed, err = camring(
        *asked(desk, "--diameter", "20,40", "--working-distance", "250", "--refine", "--out", out)
    )
    assert status == 0, err
    assert "more than" in printed and "refined.csv" in err
    with (out / "rings.csv").open(encoding="utf-8") as file:
        undominated = [row for row in csv.DictReader(file) if row["undominated"] == "True"]
    with (out / "refined.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["start_area_mm2"] for row in rows] == [row["area_mm2"] for row in undominated]
    mesh = meshes.load(desk / "trench.stl")
    for row in rows:
        assert 20 <= float(row["diameter_mm"]) <= 40 and float(row["working_distance_mm"]) == 250
        assert float(row["area_mm2"]) >= float(row["start_area_mm2"])
        made = read(out / "refined" / f"d{float(row['diameter_mm']):.9g}_h250_fov36x24.json")
        own = exact.evaluate(mesh, made.ring.cameras(made.angles), demand=made.demand)
        assert float(row["area_mm2"]) == pytest.approx(own.area, rel=1e-9)
        assert float(row["rms_error_mm"]) == pytest.approx(own.error_rms, rel=1e-7)
    status, _, err = camring(*asked(desk, "--diameter", "20", "--refine", "--out", tmp_path / "one"))
    assert status == 2 and "--refine needs room" in err
