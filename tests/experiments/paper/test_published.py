"""The published areas as the commands read them."""

from experiments.paper.published import CAMERA_COUNTS, FILE, published_areas
from tests.support import PUBLISHED_AREAS


def test_all_240_areas_are_there():
    areas = published_areas()
    assert len(areas) == 240
    assert {key[-1] for key in areas} == set(CAMERA_COUNTS)
    assert FILE.read_bytes() == PUBLISHED_AREAS.read_bytes()
