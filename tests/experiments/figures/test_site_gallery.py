"""The contact sheet of the built-in sites: what is drawn lies where the lengths say, and the file is a picture."""

import re

import matplotlib.image
import numpy as np
import pytest
import shapely
from matplotlib.colors import to_rgb

import meshes
from experiments.cli.app import main
from experiments.figures import site_gallery


@pytest.fixture(scope="module")
def artery():
    return site_gallery.cut_open("circ_artery", 50, detail="coarse")


def test_all_sites_are_on_the_sheet():
    shown = [panel for row in site_gallery.gallery_rows() for panel in row]
    assert len(set(shown)) == len(shown)
    assert {name for name, _ in shown} == set(meshes.SITES)
    assert all(depth in meshes.SITES[name].depths for name, depth in shown)


def test_lengths_on_the_cut_are_those_of_the_site(artery):
    # Across the cut, obliquely seen lengths shrink by the cosine of the angle, and by 3 % of perspective at most.
    ends = artery.on_cut([-5.0, 5.0], [25.0, 25.0])
    assert ends[1, 0] - ends[0, 0] == pytest.approx(10.0 * np.cos(site_gallery.ASIDE), rel=0.03)
    bottom, top = artery.on_cut([0.0, 0.0], [0.0, 50.0])
    assert top[1] - bottom[1] == pytest.approx(50.0 * np.cos(site_gallery.ELEVATION), rel=0.03)
    assert artery.n_faces == len(meshes.site("circ_artery", 50, "coarse").faces)
    np.testing.assert_allclose(artery.block, [60.0, 60.0, 62.0])


@pytest.mark.parametrize(
    ("across", "height", "colour"),
    [
        (-20.0, 25.0, site_gallery.CUT_COLOUR),
        (20.0, 10.0, site_gallery.CUT_COLOUR),
        (0.0, 20.0, site_gallery.LINING_COLOUR),
        (-11.5, 42.0, site_gallery.LINING_COLOUR),  # long faces of the wall that end at the artery
        (0.0, 33.2, site_gallery.TUBE_COLOUR),  # the artery: 31 high, 4 behind the cut, seen from 30° above
    ],
)
def test_tissue_channel_and_vessel_are_told_apart(artery, across, height, colour):
    x, y = artery.on_cut(across, height)
    drawn = artery.fill[shapely.contains_xy(artery.polygons, x, -y)]
    assert len(drawn) == 1
    # Shading changes how bright a colour is, not its hue.
    wanted = np.array(to_rgb(colour))
    np.testing.assert_allclose(drawn[0] / drawn[0].max(), wanted / wanted.max(), atol=0.12)


def test_what_is_visible_covers_the_picture_once(artery):
    whole = shapely.union_all(shapely.buffer(artery.polygons, 1e-6))
    assert whole.area == pytest.approx(shapely.area(artery.polygons).sum(), rel=1e-4)


def test_two_sites_make_a_picture(tmp_path):
    path = tmp_path / "two.png"
    site_gallery.write_gallery(path, [[("circ_flat", 50), ("eye_anterior", 8)]], detail="coarse")
    picture = matplotlib.image.imread(path)[..., :3]
    assert [file.name for file in tmp_path.iterdir()] == ["two.png"]
    assert picture.shape[1] > picture.shape[0] > 300
    assert 0.2 < (picture.min(axis=2) < 0.95).mean() < 0.8  # sites, and paper between them
    for edge in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
        assert edge.min() == 1.0  # nothing is cut off


def test_command(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(site_gallery, "gallery_rows", lambda: [[("spine_disc", 75)]])
    with pytest.raises(SystemExit) as end:
        main(["site", "--gallery", str(tmp_path / "sites.png"), "--detail", "coarse"])
    assert not end.value.code
    assert "sites.png: 1 site cut open, detail coarse" in capsys.readouterr().out
    assert matplotlib.image.imread(tmp_path / "sites.png").size


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--gallery", "sites.jpg"], r"--gallery is sites\.jpg; its ending must be \.png"),
        (["circ_flat", "--gallery", "sites.png"], r"--gallery draws all sites; leave out NAME"),
        (["--gallery", "sites.png", "--detail", "huge"], r"there is no detail 'huge'; choose one of coarse"),
        (["--gallery", "there.png"], r"already holds there\.png; .*--force"),
    ],
)
def test_refusals(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.png").write_bytes(b"")
    with pytest.raises(SystemExit) as end:
        main(["site", *arguments])
    assert end.value.code == 2
    assert re.search(message, capsys.readouterr().err)
    assert [file.name for file in tmp_path.iterdir()] == ["there.png"]
