"""The published areas as the commands read them."""

from pathlib import Path

from experiments.paper.published import CAMERA_COUNTS, FILE, published_areas


def test_all_240_areas_are_there():
    areas = published_areas()
    assert len(areas) == 240
    assert {key[-1] for key in areas} == set(CAMERA_COUNTS)
    assert FILE.read_bytes() == (Path(__file__).parent / "published_areas.csv").read_bytes()
