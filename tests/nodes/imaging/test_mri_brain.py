"""The brain's tissue where its truth, the bias field and the leak are known."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from nodes.imaging.mri_brain import (
    even_intensities,
    fill_sulci,
    find_remains,
    find_tissue,
    share_near_skin,
)
from nodes.imaging.parameters import SegmentMriParameters
from tests.nodes.imaging.head_phantom import CENTRE, GREY, WHITE, Phantom, draw

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters" / "segment_mri.yml"
PARAMETERS = SegmentMriParameters(**yaml.safe_load(DEFAULTS.read_text()))


@pytest.fixture(scope="module")
def drawn():
    mri, truth = draw(Phantom())
    places = np.stack(np.indices(truth.voxels.shape), -1) * 2.0 + truth.patient_from_index[:3, 3]
    return mri.voxels, truth.voxels, places - CENTRE


def dice(a, b) -> float:
    return 2 * (a & b).sum() / (a.sum() + b.sum())


def test_a_smooth_bias_field_is_divided_out(drawn):
    voxels, labels, places = drawn
    bias = 1 + 0.3 * np.sin(places[..., 0] / 60) + 0.2 * places[..., 2] / 80
    white = voxels == WHITE
    biased = (voxels * bias).astype(np.float32)
    values = even_intensities(biased + 50, labels > 2, 50.0)
    assert np.median(values[labels > 2]) == pytest.approx(1, abs=1e-3)
    before = biased[white].std() / biased[white].mean()
    assert values[white].std() / values[white].mean() < 0.25 * before


def test_a_surface_that_broke_out_to_the_scalp_is_cut_back(drawn):
    voxels, labels, places = drawn
    brain = labels > 2
    # Bone over the temple only a little darker than brain, and a surface that passed it.
    window = (places[..., 0] > 50) & (np.hypot(places[..., 1], places[..., 2]) < 18)
    thin = np.where(window & ~brain & (labels > 0), WHITE, voxels)
    thin = np.where(window & (labels == 2), 0.7 * WHITE, thin)
    surface = brain | (window & (labels > 0))
    values = (thin / WHITE).astype(np.float32)
    found = find_tissue(values, surface, labels > 0, 2.0, PARAMETERS)
    scalp = window & (labels == 1) & (places[..., 0] > 73)
    assert surface[scalp].any() and not found[scalp].any()
    assert dice(found, brain) > 0.97


def test_a_thin_membrane_is_no_brain(drawn):
    voxels, labels, _ = drawn
    brain = labels > 2
    values = (voxels / WHITE).astype(np.float32)
    found = find_tissue(values, brain, labels > 0, 2.0, PARAMETERS)
    assert found[voxels == GREY].mean() > 0.97
    assert not found[labels == 2].any()


def test_the_share_near_skin_tells_scalp_from_brain(drawn):
    _, labels, _ = drawn
    assert share_near_skin(labels > 2, labels > 0, 2.0, PARAMETERS) == 0
    assert share_near_skin(labels > 0, labels > 0, 2.0, PARAMETERS) > 0.9


def test_remains_lose_specks_and_gain_ventricles():
    mri, truth = draw(Phantom(stripped=True))
    bright = mri.voxels > 60
    bright[2:4, 2:4, 2:4] = True
    remains = find_remains(bright, 2.0, PARAMETERS)
    assert remains[truth.mask("ventricles")].all() and not remains[:5, :5, :5].any()


def test_narrow_sulci_are_filled_and_wide_ones_are_not():
    brain = np.ones((60, 60, 60), bool)
    brain[:, :, :8] = brain[:, :, 52:] = False
    brain[20:23, :, 20:] = False
    brain[40:54, :, 20:] = False
    filled = fill_sulci(brain, 4.0, 1.0)
    assert filled[20:23, 5:55, 20:48].all() and not filled[46, 5:55, 30:].any()
