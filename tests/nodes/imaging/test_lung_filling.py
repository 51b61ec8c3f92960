"""Values of a collapse: mass, noise and edges against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from nodes.imaging.lung_filling import condense, make_noise, mass_of, measure_noise, wet_rim


@given(factor=st.floats(1, 4), seed=st.integers(0, 100))
def test_condensing_reaches_the_mass_and_presses_no_tissue(factor, seed):
    chance = np.random.default_rng(seed)
    values = chance.uniform(-950, -780, 500).astype(np.float32)
    values[:20] = 45.0
    shares = chance.uniform(0.5, 1, 500).astype(np.float32)
    mass = float((((values + 1000) * shares)[20:].sum() * factor + 1045 * shares[:20].sum()) / 1000)
    pressed = condense(values, shares, mass)
    assert float((pressed + 1000) @ shares) / 1000 == pytest.approx(mass, rel=1e-3)
    np.testing.assert_allclose(pressed[:20], 45.0, atol=1e-3)
    assert (pressed >= values - 1e-2).all() and pressed.max() <= 45.01


def test_what_holds_no_more_becomes_airless_and_no_denser():
    pressed = condense(np.full(9, -850, np.float32), np.ones(9, np.float32), 1e6)
    np.testing.assert_allclose(pressed, 40.0, atol=1e-3)


def test_mass_is_that_of_water_for_water_and_nothing_for_air():
    assert mass_of(np.array([0.0, 0.0, -1000.0, -1024.0])) == pytest.approx(2.0)


@pytest.mark.parametrize("axial", [0, 2])
@pytest.mark.parametrize("width", [0.0, 0.7, 1.2])
def test_noise_is_measured_as_it_was_made(width, axial):
    shape = [60, 60, 60]
    shape[axial] = 8
    noise = np.random.default_rng(0).normal(size=shape)
    noise = ndimage.gaussian_filter(noise, [0 if a == axial else width for a in range(3)])
    sds = np.linspace(10, 40, 8)
    noise *= np.expand_dims(sds, [a for a in range(3) if a != axial]) / noise.std()
    noise[tuple(slice(30, None) if a == 1 else slice(None) for a in range(3))] += 900  # an edge
    found, found_width = measure_noise(noise, np.ones(shape, bool), axial)
    np.testing.assert_allclose(found, sds, rtol=0.12)
    correlation = [np.exp(-1 / (4 * w**2)) if w else 0.0 for w in (found_width, width)]
    assert correlation[0] == pytest.approx(correlation[1], abs=0.1)


def test_made_noise_has_the_spread_of_each_slice():
    sds = np.array([5.0, 20.0, 40.0])
    noise = make_noise((90, 90, 3), sds, 0.8, 2, np.random.default_rng(1))
    np.testing.assert_allclose(noise.std(axis=(0, 1)), sds, rtol=0.1)


def test_without_tissue_there_is_no_noise_to_measure():
    sds, width = measure_noise(np.zeros((9, 9, 4)), np.zeros((9, 9, 4), bool), 2)
    assert not sds.any() and width == 0


def test_an_edge_voxel_keeps_its_wall_and_gets_filling_for_lung():
    shares = np.linspace(0, 1, 11)  # of lung
    before = ((1 - shares) * 40 + shares * -850).astype(np.float32)
    after = wet_rim(before, (-850.0, 0.0), 8.0)
    np.testing.assert_allclose(after[1:], ((1 - shares) * 40 + shares * 8)[1:], atol=1e-2)
    assert after[0] == before[0]
