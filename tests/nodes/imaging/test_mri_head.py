"""The head, its middle and its levels, where they are known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from nodes.errors import BadInput
from nodes.imaging.mri_head import find_head, find_range, is_skull_stripped
from nodes.imaging.parameters import SegmentMriParameters
from tests.nodes.imaging.head_phantom import CENTRE, Phantom, draw

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters" / "segment_mri.yml"
PARAMETERS = SegmentMriParameters(**yaml.safe_load(DEFAULTS.read_text()))


def head_of(mri):
    return find_head(mri.voxels, mri.patient_from_index, find_range(mri, PARAMETERS), PARAMETERS)


@pytest.fixture(scope="module")
def drawn():
    return draw(Phantom(seed=3))


def test_skin_holds_all_of_the_head_and_no_air(drawn):
    mri, truth = drawn
    mask, true = head_of(mri).mask, truth.voxels > 0
    assert 2 * (mask & true).sum() / (mask.sum() + true.sum()) > 0.98


def test_the_middle_is_the_brains_however_long_the_neck(drawn):
    mri, _ = drawn
    shorter = mri.patient_from_index.copy()
    shorter[2, 3] += 30 * 2.0
    cut = replace(mri, voxels=mri.voxels[:, :, 30:], patient_from_index=shorter)
    for image in (mri, cut):
        assert np.linalg.norm(head_of(image).centre_patient_mm - CENTRE) < 10


def test_a_holder_does_not_join_the_head(drawn):
    mri, truth = drawn
    wider = np.pad(mri.voxels, ((0, 0), (0, 12), (0, 0)))
    wider[:, -2:, :] = 150  # behind the head, in sight
    mask = head_of(replace(mri, voxels=wider)).mask
    assert not mask[:, -2:].any()
    assert mask[:, :-12][truth.voxels > 1].all()


@pytest.mark.parametrize("stripped", [True, False])
def test_a_stripped_skull_is_seen(stripped):
    mri, _ = draw(Phantom(stripped=stripped, seed=4))
    assert is_skull_stripped(mri.voxels, head_of(mri), PARAMETERS) == stripped


def test_an_image_of_one_value_has_no_range(drawn):
    with pytest.raises(BadInput, match="nearly all alike"):
        find_range(replace(drawn[0], voxels=np.full((20, 20, 20), 3, np.int16)), PARAMETERS)
