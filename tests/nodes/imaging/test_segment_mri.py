"""Segmentation of head MRI against a phantom's truth, its own mirror and scale, and real heads."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy import ndimage

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin
from nodes.imaging.parameters import SegmentMriParameters
from nodes.imaging.segment_mri import NAMES, segment_mri
from tests.nodes.imaging.head_phantom import BONE, GAP, Phantom, draw

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters" / "segment_mri.yml"
PARAMETERS = SegmentMriParameters(**yaml.safe_load(DEFAULTS.read_text()))
COARSE = PARAMETERS.model_copy(update={"working_voxel_mm": 2.0, "surface_steps": 300})
NOTHING = LabelMap(np.zeros((1, 1, 1), np.uint8), np.eye(4), (), Origin("nothing"))


def volumes_ml(labels: LabelMap) -> dict[str, float]:
    voxel_ml = abs(np.linalg.det(labels.patient_from_index)) / 1000
    return {name: labels.mask(name).sum() * voxel_ml for name in labels.names}


def brain_of(labels: LabelMap) -> np.ndarray:
    return labels.mask("left_brain") | labels.mask("right_brain") | labels.mask("ventricles")


def dice(a, b) -> float:
    return 2 * (a & b).sum() / (a.sum() + b.sum())


def height_of(labels: LabelMap) -> np.ndarray:
    """z of every voxel, mm."""
    return np.einsum(
        "i,ijkl->jkl", labels.patient_from_index[2, :3], np.indices(labels.voxels.shape)
    )


def assert_skull_is_closed_above_its_base(labels: LabelMap) -> None:
    """Nothing but the skull parts the brain from the scalp, but for the base."""
    brain = brain_of(labels)
    height = height_of(labels)
    above = height > height[brain].min() + 20
    parts, _ = ndimage.label(above & ~labels.mask("skull"))
    inside = np.unique(parts[brain & above])
    outside = np.unique(parts[above & (labels.voxels == 0)])
    assert not set(inside) & set(outside)


@pytest.fixture(scope="module")
def drawn():
    return draw(Phantom(seed=1))


@pytest.fixture(scope="module")
def found(drawn):
    return segment_mri(drawn[0], NOTHING, COARSE)


def test_phantom_agrees_with_its_truth(drawn, found):
    _, truth = drawn
    assert found.names == NAMES
    assert dice(brain_of(found), brain_of(truth)) > 0.97
    for side in ("left_brain", "right_brain"):
        assert dice(found.mask(side), truth.mask(side)) > 0.96
    assert dice(found.mask("ventricles"), truth.mask("ventricles")) > 0.85
    height = height_of(truth)
    above = height > height[brain_of(truth)].mean()
    assert dice(found.mask("skull") & above, truth.mask("skull") & above) > 0.8
    assert dice(found.voxels > 0, truth.voxels > 0) > 0.97
    assert_skull_is_closed_above_its_base(found)


def test_the_origin_says_what_is_simulated_and_estimated(found):
    assert found.origin.simulated
    assert any("skull is an estimate" in notice for notice in found.origin.notices)
    assert any("cuts the head: bottom" in notice for notice in found.origin.notices)


def test_the_result_follows_the_patients_axes_not_the_arrays(drawn, found):
    mri, _ = drawn
    flip = np.eye(4)
    flip[0, 0], flip[0, 3] = -1, mri.voxels.shape[0] - 1
    matrix = (mri.patient_from_index @ flip)[:, [2, 0, 1, 3]]
    turned = replace(mri, voxels=mri.voxels[::-1].transpose(2, 0, 1), patient_from_index=matrix)
    again = segment_mri(turned, NOTHING, COARSE).voxels.transpose(1, 2, 0)[::-1]
    assert np.mean(again != found.voxels) < 0.002


def test_scale_and_offset_of_intensities_do_not_matter(drawn, found):
    mri, _ = drawn
    scaled = replace(mri, voxels=np.rint(mri.voxels * 17 - 400).astype(np.int16))
    assert np.mean(segment_mri(scaled, NOTHING, COARSE).voxels != found.voxels) < 0.002


def test_a_stripped_brain_gets_an_estimated_skull_and_says_so():
    mri, truth = draw(Phantom(stripped=True))
    thickness = COARSE.model_copy(update={"skull_thickness_mm": BONE, "csf_gap_mm": GAP})
    labels = segment_mri(mri, NOTHING, thickness)
    assert dice(brain_of(labels), brain_of(truth)) > 0.98
    assert any("the image is skull-stripped" in notice for notice in labels.origin.notices)
    _, whole = draw(Phantom())
    height = height_of(whole)
    above = height > height[brain_of(whole)].mean()
    assert dice(labels.mask("skull") & above, whole.mask("skull") & above) > 0.85
    assert_skull_is_closed_above_its_base(labels)


def test_without_visible_ventricles_their_label_is_empty_with_notice():
    mri, _ = draw(Phantom(ventricles=False))
    labels = segment_mri(mri, NOTHING, COARSE)
    assert not labels.mask("ventricles").any()
    assert any("ventricles is empty" in notice for notice in labels.origin.notices)


def test_labels_drawn_by_hand_win(drawn, found):
    mri, truth = drawn
    lesion = np.zeros(mri.voxels.shape, np.uint8)
    lesion[40:45, 50:55, 70:75] = 1
    given = replace(truth, voxels=lesion, names=("lesion",))
    labels = segment_mri(mri, given, COARSE)
    np.testing.assert_array_equal(labels.mask("lesion"), lesion == 1)
    np.testing.assert_array_equal(labels.voxels[lesion == 0], found.voxels[lesion == 0])


def test_labels_on_another_grid_are_refused(drawn):
    given = replace(drawn[1], voxels=np.zeros((5, 5, 5), np.uint8))
    with pytest.raises(BadInput, match="grid"):
        segment_mri(drawn[0], given, COARSE)


def small_ball() -> np.ndarray:
    distance = np.linalg.norm(np.indices((98, 116, 118)) - 50, axis=0)
    return np.where(distance < 25, 900, 0).astype(np.int16)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"unit": "HU"}, "pipeline for a CT"),
        ({"voxels": np.full((98, 116, 118), 7, np.int16)}, "nearly all alike"),
        ({"voxels": np.ones((98, 116, 20), np.int16)}, "a slab"),
        ({"voxels": small_ball()}, "no head found"),
    ],
)
def test_what_is_no_head_mri_is_refused(drawn, change, words):
    with pytest.raises(BadInput, match=words):
        segment_mri(replace(drawn[0], **change), NOTHING, COARSE)


def test_a_brain_beyond_human_size_is_refused(drawn):
    mri, _ = drawn
    larger = replace(mri, patient_from_index=mri.patient_from_index * 1.25)
    with pytest.raises(BadInput, match=r"ml"):
        segment_mri(larger, NOTHING, COARSE)


def read_nifti(path: Path) -> Volume:
    import SimpleITK as sitk

    image = sitk.ReadImage(str(path))
    matrix = np.eye(4)
    matrix[:3, :3] = np.reshape(image.GetDirection(), (3, 3)) * image.GetSpacing()
    matrix[:3, 3] = image.GetOrigin()
    voxels = sitk.GetArrayFromImage(image).T.astype(np.int16)
    return Volume(voxels, matrix, "intensity", Origin("a volume file"))


def every_other(volume: Volume) -> Volume:
    """Half the resolution, from the second voxel on: the atlas has its midplane between these."""
    matrix = volume.patient_from_index @ np.diag([2.0, 2, 2, 1])
    matrix[:3, 3] += volume.patient_from_index[:3, :3].sum(axis=1)
    return replace(volume, voxels=volume.voxels[1::2, 1::2, 1::2], patient_from_index=matrix)


def test_a_real_head_has_a_brain_of_human_size_in_two_like_halves(test_data):
    mri = read_nifti(test_data / "head_mri" / "chris_t1.nii.gz")
    labels = segment_mri(mri, NOTHING, PARAMETERS)
    ml = volumes_ml(labels)
    brain = brain_of(labels)
    assert 1100 < brain.sum() * ml["left_brain"] / labels.mask("left_brain").sum() < 1800
    assert ndimage.label(brain)[1] == 1
    assert abs(ml["left_brain"] / ml["right_brain"] - 1) < 0.05
    assert 5 < ml["ventricles"] < 40
    assert_skull_is_closed_above_its_base(labels)
    left = np.argwhere(labels.mask("left_brain")).mean(0) @ labels.patient_from_index[:3, :3].T
    right = np.argwhere(labels.mask("right_brain")).mean(0) @ labels.patient_from_index[:3, :3].T
    assert left[0] - right[0] > 50  # the patient's left is +x


@pytest.fixture(scope="module")
def atlas_folder() -> Path:
    found = importlib.util.find_spec("nilearn")
    if found is None:
        pytest.skip("nilearn is not installed")
    return Path(found.origin).parent / "datasets" / "data"


def test_the_atlas_brain_is_symmetric_and_agrees_with_its_tissue_maps(atlas_folder):
    name = "mni_icbm152_{}_tal_nlin_sym_09a_converted.nii.gz"
    mri = every_other(read_nifti(atlas_folder / name.format("t1")))
    labels = segment_mri(mri, NOTHING, COARSE)
    maps = [every_other(read_nifti(atlas_folder / name.format(x))).voxels for x in ("gm", "wm")]
    assert dice(brain_of(labels), sum(maps) > 127) > 0.94
    ml = volumes_ml(labels)
    assert 1100 < brain_of(labels).sum() * 0.008 < 2000
    assert abs(ml["left_brain"] / ml["right_brain"] - 1) < 0.01
    assert any("the image is skull-stripped" in notice for notice in labels.origin.notices)
