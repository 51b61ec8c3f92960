"""The phantom: human in size and values, adjustable, the same every time, valid for everyone."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from nodes.errors import BadInput
from nodes.imaging.make_thorax_phantom import make_thorax_phantom
from nodes.imaging.parameters import MakeThoraxPhantomParameters

CATALOG = Path(__file__).resolve().parents[3] / "catalog" / "parameters"
DEFAULTS = MakeThoraxPhantomParameters(
    **yaml.safe_load((CATALOG / "make_thorax_phantom.yml").read_text())
)
COARSE = DEFAULTS.model_copy(
    update={"pixel_spacing_mm": 4.0, "slice_thickness_mm": 4.0, "noise_sd_hu": 0.0, "blur_mm": 0.0}
)


@cache
def changed(**values):
    return make_thorax_phantom(COARSE.model_copy(update=values))


@pytest.fixture(scope="module")
def phantom():
    return changed()


@pytest.fixture(scope="module")
def default():
    return make_thorax_phantom(DEFAULTS)


def stacked(files):
    ordered = sorted(files.slices, key=lambda plane: plane.patient_from_pixel[2, 3])
    return np.stack([plane.pixels.T for plane in ordered], axis=-1)


def count_parts(mask):
    return ndimage.label(mask)[1]


def test_volumes_are_those_of_an_adult(default):
    _, truth = default
    voxel_ml = abs(np.linalg.det(truth.patient_from_index)) / 1000
    volumes = {name: truth.mask(name).sum() * voxel_ml for name in truth.names}
    assert 2000 < volumes["left_lung"] < 3500
    assert 2000 < volumes["right_lung"] + volumes["effusion"] + volumes["adhesion"] < 3500
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
    assert -900 < medians["left_lung"] < -800
    assert -780 < medians["right_lung"] < -700  # denser, since it is collapsed
    assert medians["airway"] < -950
    assert 0 <= medians["effusion"] <= 20
    assert 0 <= medians["adhesion"] <= 60
    assert medians["bone"] > 180
    assert -120 < np.percentile(voxels[truth.mask("body")], 10) < -80  # fat
    assert voxels[0, 0, 0] == -1000


def test_slices_are_shuffled_and_simulated(phantom):
    files, truth = phantom
    heights = [plane.patient_from_pixel[2, 3] for plane in files.slices]
    assert sorted(heights) != heights
    assert files.simulated and truth.origin.simulated


@pytest.mark.parametrize(("side", "share"), [("right", 0.0), ("right", 0.5), ("left", 0.25)])
def test_the_effusion_takes_its_share_of_the_cavity_on_its_side(side, share):
    _, truth = changed(effusion_share=share, effusion_side=side, adhesions=0)
    fluid = truth.mask("effusion")
    lung = truth.mask(f"{side}_lung").sum()
    assert fluid.sum() / (fluid.sum() + lung) == pytest.approx(share, abs=0.004)
    if share:
        x = ndimage.center_of_mass(fluid)[0] - truth.voxels.shape[0] / 2
        assert (x > 0) == (side == "left")  # +x is the patient's left


def test_the_lung_lies_behind_or_before_the_fluid_as_asked():
    for lies, sign in (("posterior", 1), ("anterior", -1)):
        _, truth = changed(lung_lies=lies, effusion_share=0.5, adhesions=0)
        lung, fluid = (
            ndimage.center_of_mass(truth.mask(name))[1] for name in ("right_lung", "effusion")
        )
        assert sign * (lung - fluid) * 4.0 > 15  # mm; +y is posterior


def test_a_collapse_changes_nothing_but_the_old_lung():
    ill = changed(effusion_share=0.5, variation=1.0, seed=3)[1]
    healthy = changed(effusion_share=0.0, variation=1.0, seed=3)[1]
    before = healthy.mask("right_lung") | healthy.mask("airway")
    after = np.isin(ill.voxels, [ill.names.index(n) + 1 for n in
                                 ("right_lung", "effusion", "adhesion", "airway")])  # fmt: skip
    assert not (healthy.mask("right_lung") & ~after).any()
    assert not (ill.mask("effusion") & ~before).any()
    np.testing.assert_array_equal(healthy.mask("bone"), ill.mask("bone"))
    np.testing.assert_array_equal(healthy.mask("left_lung"), ill.mask("left_lung"))


def test_a_collapsed_lung_keeps_its_mass():
    """Density times volume of the lung, vessels and airways apart, is that of the healthy lung."""
    mass = []
    for share in (0.0, 0.5):
        files, truth = changed(effusion_share=share, adhesions=0)
        core = ndimage.binary_erosion(truth.mask("right_lung"), iterations=2)
        density = np.median(stacked(files)[core]) + 1000
        mass.append(density * (1 - share))
    assert mass[1] == pytest.approx(mass[0], rel=0.01)


def test_adhesions_join_lung_and_chest_wall_through_the_fluid(default):
    _, truth = default
    parts, count = ndimage.label(truth.mask("adhesion"), np.ones((3, 3, 3)))
    assert count == DEFAULTS.adhesions
    lung, wall = truth.mask("right_lung"), truth.mask("body") | truth.mask("bone")
    fluid = truth.mask("effusion")
    for number in range(1, count + 1):
        around = ndimage.binary_dilation(parts == number, np.ones((3, 3, 3)))
        assert (around & lung).any() and (around & wall).any() and (around & fluid).any()


def test_everything_scales_with_the_chest():
    _, large = changed(chest_width_mm=350, pixel_spacing_mm=7, slice_thickness_mm=7)
    _, small = changed(chest_width_mm=250, pixel_spacing_mm=5, slice_thickness_mm=5)
    np.testing.assert_array_equal(large.voxels, small.voxels)


@pytest.mark.parametrize("blur_mm", [0.0, 5.0])
def test_noise_has_the_wanted_spread_and_no_bias(blur_mm):
    quiet, truth = changed(blur_mm=blur_mm)
    noisy, _ = changed(noise_sd_hu=30.0, blur_mm=blur_mm)
    difference = (stacked(noisy).astype(float) - stacked(quiet))[truth.mask("body")]
    assert difference.std() == pytest.approx(30, rel=0.02)
    assert abs(difference.mean()) < 0.5


def test_blur_keeps_all_mass_and_softens_edges_and_noise():
    sharp, truth = changed()
    soft, same = changed(blur_mm=5.0)
    np.testing.assert_array_equal(truth.voxels, same.voxels)
    assert stacked(soft).mean() == pytest.approx(stacked(sharp).mean(), abs=0.1)
    steps = [abs(np.diff(stacked(files).astype(float), axis=0)).max() for files in (sharp, soft)]
    assert steps[1] < 0.8 * steps[0]


def test_the_seed_alone_decides_about_chance():
    noisy = {"noise_sd_hu": 15.0, "variation": 1.0}
    again = make_thorax_phantom(COARSE.model_copy(update=noisy))
    (one, _), (same, _), (other, _) = changed(**noisy), again, changed(**noisy, seed=2)
    values = [np.stack([plane.pixels for plane in files.slices]) for files in (one, same, other)]
    np.testing.assert_array_equal(values[0], values[1])
    assert (values[0] != values[2]).any()


def test_more_variation_is_more_difference_and_none_is_the_average_build():
    average = changed()[1].mask("bone")
    differing = [
        (changed(variation=v, seed=3, effusion_share=0.0)[1].mask("bone") != average).sum()
        for v in (0.0, 0.3, 1.0)
    ]
    assert differing[0] == 0 < differing[1] < differing[2]


def test_six_phantoms_are_six_anatomies():
    grid = {"pixel_spacing_mm": 6.0, "slice_thickness_mm": 6.0}
    lungs = [changed(variation=1.0, seed=seed, **grid)[1].mask("left_lung") for seed in range(6)]
    volumes = [float(lung.sum()) for lung in lungs]
    assert np.std(volumes) > 0.04 * np.mean(volumes)
    dice = [2 * (a & b).sum() / (a.sum() + b.sum())
            for n, a in enumerate(lungs) for b in lungs[:n]]  # fmt: skip
    assert max(dice) < 0.985


@pytest.mark.parametrize(("pixel", "thickness"), [(6.0, 6.0), (4.8, 10.0)])
def test_voxels_hold_the_mean_of_what_a_finer_scan_shows_in_them(pixel, thickness):
    """Against the same phantom with each voxel cut in 27."""
    build = {"variation": 1.0, "adhesions": 0}  # adhesions are never thinner than voxels
    coarse = stacked(changed(pixel_spacing_mm=pixel, slice_thickness_mm=thickness, **build)[0])
    fine = changed(pixel_spacing_mm=pixel / 3, slice_thickness_mm=thickness / 3, **build)[0]
    fine = stacked(fine)
    a, b, c = (n // 3 for n in fine.shape)
    assert (a, b, c) == coarse.shape
    mean = fine.reshape(a, 3, b, 3, c, 3).mean(axis=(1, 3, 5))
    error = coarse - mean
    assert abs(error.mean()) < 0.5
    assert np.sqrt((error**2).mean()) < 8
    assert np.quantile(abs(error), 0.99) < 30


def test_too_many_voxels_are_refused():
    with pytest.raises(BadInput, match="at most 400,000,000 voxels"):
        changed(chest_width_mm=600, pixel_spacing_mm=0.4, slice_thickness_mm=0.4)


@settings(max_examples=4, deadline=None)
@given(
    seed=st.integers(0, 10**9),
    variation=st.sampled_from([0.0, 0.5, 1.0]),
    share=st.floats(0, 0.7),
    side=st.sampled_from(["left", "right"]),
    lies=st.sampled_from(["posterior", "anterior"]),
    width=st.floats(250, 450),
    adhesions=st.integers(0, 12),
)
def test_every_phantom_is_a_valid_thorax(seed, variation, share, side, lies, width, adhesions):
    grid = {"pixel_spacing_mm": width / 80, "slice_thickness_mm": width / 80}
    _, truth = changed(
        seed=seed, variation=variation, effusion_share=share, effusion_side=side,
        lung_lies=lies, chest_width_mm=width, adhesions=adhesions, **grid,
    )  # fmt: skip
    for name in ("left_lung", "right_lung", "airway"):
        assert count_parts(truth.mask(name)) == 1
    fluid = (truth.mask("effusion") | truth.mask("adhesion")).sum()
    lung = truth.mask(f"{side}_lung").sum()
    assert fluid / (fluid + lung) == pytest.approx(share, abs=0.01)
    if share > 0.2:  # thinner fluid is a film with gaps
        parts = np.bincount(ndimage.label(truth.voxels >= 6)[0].ravel())[1:]
        assert parts.max() > 0.9 * fluid
    air = ndimage.binary_dilation(truth.mask("airway")[:, :, :-1])  # its top leaves the image
    assert not (air & (truth.voxels[:, :, :-1] == 0)).any()
    assert not (air & truth.mask("effusion")[:, :, :-1]).any()
    x = [ndimage.center_of_mass(truth.mask(name))[0] for name in ("right_lung", "left_lung")]
    assert x[0] < truth.voxels.shape[0] / 2 < x[1]


@settings(max_examples=4, deadline=None)
@given(
    width=st.floats(100, 600),
    pixel=st.floats(4.5, 6),
    thickness=st.floats(5, 12),
    share=st.floats(0, 0.7),
)
def test_any_allowed_grid_gives_all_large_labels(width, pixel, thickness, share):
    files, truth = changed(chest_width_mm=width, pixel_spacing_mm=pixel,
                           slice_thickness_mm=thickness, effusion_share=share)  # fmt: skip
    for name in ("body", "bone", "left_lung", "right_lung"):
        assert truth.mask(name).any()
    trachea = 8.5 * width / 350  # radius in mm: wider than half a pixel's diagonal, it shows
    assert truth.mask("airway").any() or trachea < 0.71 * pixel
    assert truth.mask("effusion").any() or share < 0.01
    assert len(files.slices) == truth.voxels.shape[2]
