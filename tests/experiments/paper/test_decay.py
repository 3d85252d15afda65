"""Fits of negative exponential decays: known curves come back, and the published curves are met."""

import numpy as np
import pytest

from experiments.paper.areas import Area
from experiments.paper.cases import CIRCULAR, Case
from experiments.paper.decay import fit_decays
from experiments.paper.fits import chosen_fit, determined, fit_rows, fitted, read_fits, write_fits
from experiments.paper.published import CAMERA_COUNTS, published_areas

N = np.array(CAMERA_COUNTS, dtype=float)


def test_a_curve_of_three_phases_comes_back():
    area = 4000 - 1500 * np.exp(-(N - 2) / 0.9) - 300 * np.exp(-(N - 2) / 6) - 80 * np.exp(-(N - 2) / 60)
    three, two = fit_decays(N, area)
    assert (three.n_phases, two.n_phases) == (3, 2)  # the better one first
    np.testing.assert_allclose([three.plateau, *three.amplitudes], [4000, 1500, 300, 80], rtol=1e-5)
    np.testing.assert_allclose(three.decays, [0.9, 6, 60], rtol=1e-4)
    assert three.r_squared == pytest.approx(1.0)
    assert two.aicc > three.aicc


def test_two_phases_win_where_noise_is_all_that_a_third_could_fit():
    # Residuals that alternate in sign look like no decay at all.
    noise = 2.0 * (-1.0) ** np.arange(len(N))
    clean = 4000 - 1500 * np.exp(-(N - 2) / 1.5) - 200 * np.exp(-(N - 2) / 20)
    best = fit_decays(N, clean + noise)[0]
    assert best.n_phases == 2
    errors = np.array([best.plateau_error, *best.amplitude_errors, *best.decay_errors])
    values = np.array([best.plateau, *best.amplitudes, *best.decays])
    assert (errors > 0).all()
    assert (np.abs(values - [4000, 1500, 200, 1.5, 20]) < 4 * errors).all()


def test_standard_errors_are_those_of_many_repetitions():
    clean = 4000 - 1500 * np.exp(-(N - 2) / 1.5) - 200 * np.exp(-(N - 2) / 20)
    random = np.random.default_rng(0)
    fits = [fit_decays(N, clean + random.normal(0, 2.0, len(N))) for _ in range(25)]
    two = [fit for found in fits for fit in found if fit.n_phases == 2]
    spread = np.std([[fit.plateau, *fit.decays] for fit in two], axis=0, ddof=1)
    claimed = np.sqrt(np.mean(np.square([[fit.plateau_error, *fit.decay_errors] for fit in two]), axis=0))
    # 25 repetitions tell a spread within some 14 %, and these have few degrees of freedom besides.
    np.testing.assert_allclose(claimed, spread, rtol=0.5)


def test_scale_changes_areas_only():
    area = published_curve("circ_overhang", 50)
    small, large = fit_decays(N, area)[0], fit_decays(N, 1e4 * area)[0]
    np.testing.assert_allclose(large.decays, small.decays, rtol=1e-6)
    np.testing.assert_allclose(large.plateau, 1e4 * small.plateau, rtol=1e-9)


def published_curve(site, depth, included=False):
    published = published_areas()
    return np.array([published[site, depth, "36x24", included, n] for n in CAMERA_COUNTS])


@pytest.mark.parametrize("depth", [50, 100])
@pytest.mark.parametrize("site", CIRCULAR)
def test_published_curves_of_circular_sites_are_met(site, depth):
    assert fit_decays(N, published_curve(site, depth))[0].r_squared >= 0.99


def test_too_few_points_give_no_fit():
    assert fit_decays(N[:7], published_curve("circ_flat", 50)[:7]) == []
    assert [fit.n_phases for fit in fit_decays(N[:9], published_curve("circ_flat", 50)[:9])] == [2]


def test_table_of_fits_reads_back(tmp_path):
    case = Case("circ_artery", 50, "36x24")
    areas = [
        Area(case.site, case.depth, case.fov, included, n, float(area), "")
        for included in (True, False)
        for n, area in zip(CAMERA_COUNTS, 1.02 * published_curve("circ_artery", 50, included), strict=True)
    ]
    rows = fit_rows(areas, [case])
    write_fits(tmp_path / "fits.csv", rows)
    again = read_fits(tmp_path / "fits.csv")
    assert [repr(row) for row in again] == [repr(row) for row in rows]  # as text, for nan is not equal to itself
    ours, theirs = chosen_fit(again, case, False), chosen_fit(again, case, False, "published")
    assert ours is not None and theirs is not None
    assert ours.plateau == pytest.approx(1.02 * theirs.plateau)
    on_curve = fitted(ours, N)
    left = 1.02 * published_curve("circ_artery", 50) - on_curve
    spread = 1.02 * published_curve("circ_artery", 50)
    assert 1 - left @ left / np.sum((spread - spread.mean()) ** 2) == pytest.approx(ours.r_squared)


def test_what_the_data_tell():
    assert determined(0.1, 1.0)
    assert not determined(2.0, 1.0)
    assert not determined(float("nan"), 1.0)
