"""The phantom: human in size and values, adjustable, the same every time."""

import numpy as np
import pytest

from nodes.imaging.make_thorax_phantom import make_thorax_phantom
from nodes.imaging.parameters import MakeThoraxPhantomParameters

COARSE = MakeThoraxPhantomParameters(
    chest_width_mm=350,
    pixel_spacing_mm=3,
    slice_thickness_mm=3,
    effusion_share=0.4,
    noise_sd_hu=0,
    seed=1,
)


def changed(**values):
    return make_thorax_phantom(COARSE.model_copy(update=values))


@pytest.fixture(scope="module")
def phantom():
    return make_thorax_phantom(COARSE)


def stacked(files):
    ordered = sorted(files.slices, key=lambda plane: plane.patient_from_pixel[2, 3])
    return np.stack([plane.pixels.T for plane in ordered], axis=-1)


def test_volumes_are_those_of_an_adult(phantom):
    _, truth = phantom
    voxel_ml = abs(np.linalg.det(truth.patient_from_index)) / 1000
    volumes = {name: truth.mask(name).sum() * voxel_ml for name in truth.names}
    assert 2500 < volumes["lungs"] < 6000
    assert 30 < volumes["airway"] < 80
    assert 500 < volumes["effusion"] < 2000
    assert 600 < volumes["bone"] < 1500
    columns = np.flatnonzero((truth.voxels > 0).any(axis=(1, 2)))
    width = len(columns) * truth.patient_from_index[0, 0]
    assert width == pytest.approx(350, abs=3)


def test_values_within_each_tissue_are_its_hounsfield_units(phantom):
    files, truth = phantom
    voxels = stacked(files)
    medians = {name: np.median(voxels[truth.mask(name)]) for name in truth.names}
    assert -900 < medians["lungs"] < -700
    assert medians["airway"] < -950
    assert 0 <= medians["effusion"] <= 20
    assert medians["bone"] > 180
    assert -120 < np.percentile(voxels[truth.mask("body")], 10) < -80  # fat
    assert voxels[0, 0, 0] == -1000


def test_slices_are_shuffled_and_simulated(phantom):
    files, truth = phantom
    heights = [plane.patient_from_pixel[2, 3] for plane in files.slices]
    assert sorted(heights) != heights
    assert files.simulated and truth.origin.simulated


@pytest.mark.parametrize("share", [0.0, 0.25, 0.6])
def test_the_effusion_takes_its_share_of_the_right_cavity(share):
    _, truth = changed(effusion_share=share)
    right = np.arange(truth.voxels.shape[0]) < truth.voxels.shape[0] / 2
    fluid = truth.mask("effusion")[right].sum()
    lung = truth.mask("lungs")[right].sum()
    assert fluid / (fluid + lung) == pytest.approx(share, abs=0.02)
    assert not truth.mask("effusion")[~right].any()


def test_everything_scales_with_the_chest():
    _, large = changed(chest_width_mm=350, pixel_spacing_mm=3.5, slice_thickness_mm=3.5)
    _, small = changed(chest_width_mm=250, pixel_spacing_mm=2.5, slice_thickness_mm=2.5)
    np.testing.assert_array_equal(large.voxels, small.voxels)


def test_noise_has_the_wanted_spread_and_no_bias():
    (quiet, truth), (noisy, _) = changed(), changed(noise_sd_hu=30.0)
    difference = (stacked(noisy).astype(float) - stacked(quiet))[truth.mask("body")]
    assert difference.std() == pytest.approx(30, rel=0.01)
    assert abs(difference.mean()) < 0.5


def test_the_seed_alone_decides_about_chance():
    (one, _), (same, _), (other, _) = changed(), changed(), changed(seed=2)
    values = [np.stack([plane.pixels for plane in files.slices]) for files in (one, same, other)]
    np.testing.assert_array_equal(values[0], values[1])
    assert (values[0] != values[2]).any()


def test_edges_hold_the_share_of_what_meets_there(phantom):
    """Summed over all voxels, air missing from the image is the volume of what displaces it, and
    so is the same at a finer resolution."""
    coarse = (stacked(phantom[0]).astype(float) + 1000).sum() * 3**3
    fine = (stacked(changed(pixel_spacing_mm=2, slice_thickness_mm=2)[0]).astype(float)
            + 1000).sum() * 2**3  # fmt: skip
    assert coarse == pytest.approx(fine, rel=5e-3)
