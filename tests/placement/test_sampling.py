import numpy as np
import pytest
import trimesh

from placement import PlacementError
from placement.samples.sampling import sample_surface


@pytest.fixture(scope="module")
def shifted_block():
    """Long thin faces and small ones, away from the origin."""
    long_block = trimesh.creation.box((80, 20, 1))
    ball = trimesh.creation.icosphere(subdivisions=2, radius=6)
    ball.apply_translation((10, 0, 20))
    mesh = trimesh.util.concatenate([long_block, ball])
    mesh.apply_translation((300, -200, 70))
    return mesh


def test_points_lie_on_their_faces_and_weights_add_up(shifted_block):
    samples = sample_surface(shifted_block, 777, seed=3)
    assert len(samples) == 777
    assert samples.area == pytest.approx(shifted_block.area, rel=1e-12)
    corner = shifted_block.triangles[samples.faces, 0]
    height = np.einsum("ni,ni->n", samples.points - corner, samples.normals)
    assert np.abs(height).max() < 1e-9
    barycentric = trimesh.triangles.points_to_barycentric(shifted_block.triangles[samples.faces], samples.points)
    assert barycentric.min() > -1e-9


def test_excluded_faces_get_no_sample(shifted_block):
    exclude = shifted_block.face_normals[:, 2] > 0
    samples = sample_surface(shifted_block, 500, exclude=exclude)
    assert not exclude[samples.faces].any()
    assert samples.area == pytest.approx(shifted_block.area_faces[~exclude].sum(), rel=1e-12)


def test_unbiased_and_far_less_scattered_than_independent_points(shifted_block):
    """Area beyond a slanted plane, over many seeds."""
    n_samples, n_seeds = 400, 60
    direction = np.array([0.8, 0.5, 0.3])
    middle = shifted_block.bounds.mean(axis=0) @ direction

    def beyond(samples):
        return samples.weights[samples.points @ direction > middle].sum() / samples.area

    found = np.array([beyond(sample_surface(shifted_block, n_samples, seed=seed)) for seed in range(n_seeds)])
    true = beyond(sample_surface(shifted_block, 200_000, seed=99))
    independent = np.sqrt(true * (1 - true) / n_samples)
    assert abs(found.mean() - true) < 4 * independent / np.sqrt(n_seeds)
    assert found.std() < 0.6 * independent


def test_stratified_every_part_gets_its_share(shifted_block):
    """Slabs of a long block hold their share of the points within a few, not within a square root."""
    samples = sample_surface(shifted_block, 2000, seed=1)
    on_block = samples.points[samples.faces < 12]
    counts, _ = np.histogram(on_block[:, 0] - 300, bins=np.linspace(-40, 40, 9))
    inner = counts[1:-1]
    assert np.abs(inner - inner.mean()).max() < 2 * np.sqrt(inner.mean())
    assert inner.std() < 0.5 * np.sqrt(inner.mean())


def test_same_seed_same_points(shifted_block):
    one, same, other = (sample_surface(shifted_block, 100, seed=seed) for seed in (5, 5, 6))
    assert (one.points == same.points).all()
    assert (one.points != other.points).any()


def test_one_sample_and_zero_area_faces():
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], [[0, 1, 2], [0, 1, 3]], process=False)
    samples = sample_surface(mesh, 1)
    assert samples.faces.tolist() == [0] and samples.area == pytest.approx(0.5)


def test_errors(shifted_block):
    n_faces = len(shifted_block.faces)
    with pytest.raises(PlacementError, match=rf"one boolean for each of the {n_faces} faces"):
        sample_surface(shifted_block, 10, exclude=np.zeros(3, dtype=bool))
    with pytest.raises(PlacementError, match="one boolean for each"):
        sample_surface(shifted_block, 10, exclude=np.zeros(n_faces))
    with pytest.raises(PlacementError, match=rf"all {n_faces} faces are excluded"):
        sample_surface(shifted_block, 10, exclude=np.ones(n_faces, dtype=bool))
    with pytest.raises(PlacementError, match="number of samples is 0"):
        sample_surface(shifted_block, 0)
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
    with pytest.raises(PlacementError, match="nothing is left to sample"):
        sample_surface(flat, 10)
