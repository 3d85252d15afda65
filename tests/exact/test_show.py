"""Results show themselves in notebooks, and nothing is drawn before it is asked for."""

import base64
import io
import re
import subprocess
import sys

import matplotlib.image
import numpy as np
import pytest
import trimesh
from matplotlib.figure import Figure

import exact


@pytest.fixture(scope="module")
def step():
    """A wall on a plate, seen by three cameras on a ring that is neither at the origin nor upright."""
    mesh = trimesh.boolean.union(
        [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))], engine="manifold"
    )
    ring = exact.Ring(focus=(1.0, 2.0, 3.0), axis=(0.1, -0.2, 1.0))
    return exact.evaluate(mesh, ring.cameras(ring.equidistant(3)), threshold=2)


def test_drawing_needs_matplotlib_and_importing_does_not():
    program = "import sys, exact, placement; print([name for name in ('matplotlib', 'plotly') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_reconstruction_as_html(step):
    page = step._repr_html_()
    assert f"<td>{step.area:.4f} mm²</td>" in page
    for area in step.level_areas:
        assert f"<td>{area:.4f} mm²</td>" in page
    assert f"RMS of the predicted error along depth</td><td>{step.error_rms:.4f} mm</td>" in page
    picture = re.search(r'src="data:image/png;base64,([^"]+)"', page)
    assert picture
    pixels = matplotlib.image.imread(io.BytesIO(base64.b64decode(picture[1])))
    assert len(np.unique((pixels[..., :3] * 255).astype(int).reshape(-1, 3), axis=0)) > 50
    assert len(page) < 100_000


def test_plot_draws_into_the_axes_given(step):
    ax = Figure().subplots()
    assert step.plot(ax) is ax
    assert len(ax.collections) == 1
    assert ax.get_title().startswith(f"{step.area:.2f} mm²")


def test_a_picture_of_nothing_seen():
    plate = trimesh.creation.box((10, 10, 2))
    away = [exact.Camera.look_at((0, y, 400), (0, y, 800), (0, 1, 0)) for y in (-9.0, 9.0)]
    nothing = exact.evaluate(plate, away)
    assert nothing.plot().get_title() == "0.00 mm² seen by at least 2 cameras"
