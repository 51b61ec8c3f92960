"""Segmentation of a CT against known anatomy, and on a real chest."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.make_thorax_phantom import make_thorax_phantom
from nodes.imaging.parameters import (
    MakeThoraxPhantomParameters,
    ReadVolumeParameters,
    SegmentCtParameters,
)
from nodes.imaging.read_volume import read_volume
from nodes.imaging.score_segmentation import score_segmentation
from nodes.imaging.segment_ct import segment_ct

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters"


def defaults(kind, stage):
    return kind(**yaml.safe_load((DEFAULTS / f"{stage}.yml").read_text()))


PARAMETERS = defaults(SegmentCtParameters, "segment_ct")


def block(hu=-1000.0, size=200.0, step=5.0) -> tuple[np.ndarray, np.ndarray]:
    """A block of soft tissue in air, on a coarse grid."""
    count = int(size / step)
    voxels = np.full((count, count, 24), hu, np.int16)
    voxels[4:-4, 4:-4] = 40
    return voxels, np.diag([step, step, step, 1.0])


def chest() -> Volume:
    """A block with two lungs, a vessel in one, a bone, and gas in the stomach."""
    voxels, patient_from_index = block()
    voxels[7:17, 8:32, 3:21] = -850
    voxels[23:33, 8:32, 3:21] = -850
    voxels[10, 10:30, 10] = 40
    voxels[19:21, 30:34] = 600
    voxels[18:22, 8:14, 5:11] = -1000
    return Volume(voxels, patient_from_index, "HU", Origin("blocks"))


def test_blocks_are_found_voxel_by_voxel():
    ct = chest()
    labels = segment_ct(ct, PARAMETERS)
    lungs = ct.voxels == -850
    lungs[10, 10:30, 10] = True  # the vessel counts as lung
    np.testing.assert_array_equal(labels.mask("lungs"), lungs)
    np.testing.assert_array_equal(labels.mask("bone"), ct.voxels == 600)
    inside = np.zeros_like(lungs)
    inside[4:-4, 4:-4] = True
    np.testing.assert_array_equal(labels.voxels > 0, inside)


def test_the_result_follows_the_patients_axes_not_the_arrays():
    ct = chest()
    turned = replace(
        ct,
        voxels=ct.voxels.transpose(2, 0, 1),
        patient_from_index=ct.patient_from_index[:, [2, 0, 1, 3]],
    )
    np.testing.assert_array_equal(
        segment_ct(turned, PARAMETERS).voxels,
        segment_ct(ct, PARAMETERS).voxels.transpose(2, 0, 1),
    )


@pytest.mark.parametrize(("hu", "words"), [(600, "no lungs"), (-1000, "no body")])
def test_what_is_missing_is_named(hu, words):
    voxels = np.full((20, 20, 20), hu, np.int16)
    with pytest.raises(BadInput, match=words):
        segment_ct(Volume(voxels, np.diag([5.0, 5, 5, 1]), "HU", Origin("plain")), PARAMETERS)


def test_a_chest_without_bone_is_refused():
    ct = chest()
    with pytest.raises(BadInput, match="no bone"):
        segment_ct(replace(ct, voxels=np.minimum(ct.voxels, 60)), PARAMETERS)


def test_values_that_are_not_hounsfield_units_are_refused():
    with pytest.raises(BadInput, match="intensity"):
        segment_ct(replace(chest(), unit="intensity"), PARAMETERS)


@pytest.fixture(scope="module")
def phantom():
    return make_thorax_phantom(defaults(MakeThoraxPhantomParameters, "make_thorax_phantom"))


def test_phantom_agrees_with_its_truth_and_leaves_the_table_out(phantom):
    files, truth = phantom
    ct = read_volume(files, defaults(ReadVolumeParameters, "read_volume"))
    labels = segment_ct(ct, PARAMETERS)
    dice = score_segmentation(labels, truth).set_index("label").dice
    assert dice["lungs"] >= 0.95 and dice["bone"] >= 0.85 and dice["body"] >= 0.97
    table = (truth.voxels == 0) & (ct.voxels > -500)
    assert table.sum() > 10_000
    assert (labels.voxels[table] > 0).mean() < 0.02
    assert labels.origin.simulated
    assert any("trachea" in notice for notice in labels.origin.notices)


def test_a_real_chest_has_lungs_of_human_size_apart_from_bone(test_data):
    from catalog.formats.image_files import ImageFilesFormat

    folder = test_data / "chest_ct" / "P002"
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    ct = read_volume(ImageFilesFormat.decode(files), defaults(ReadVolumeParameters, "read_volume"))
    labels = segment_ct(ct, PARAMETERS)
    voxel_ml = abs(np.linalg.det(labels.patient_from_index)) / 1000
    lungs = labels.mask("lungs")
    assert 2500 < lungs.sum() * voxel_ml < 7000
    assert 300 < labels.mask("bone").sum() * voxel_ml < 2000
    heights = [np.flatnonzero(lungs[side].any(axis=(0, 1))) for side in (np.s_[:256], np.s_[256:])]
    assert all(len(height) * 2 > 150 for height in heights)  # both lungs, in mm
    assert np.mean(ct.voxels[lungs]) < -600
