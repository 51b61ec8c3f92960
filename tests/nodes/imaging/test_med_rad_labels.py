"""Real labels and sites of Med-RAD: one grid, targets in their nodules, starts on the airway."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from catalog.formats.label_files import LabelFilesFormat
from catalog.formats.sites import SitesFormat
from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.imaging.check_sites import check_sites
from nodes.imaging.combine_label_maps import combine_label_maps
from nodes.imaging.parameters import CheckSitesParameters
from tests.nodes.imaging.handed_in import combine_parameters

LUNG = "Lungs/TumorTargetEnvironments/Patient"
NAMES = {"bronchialTree": "airway", "pleuralBoundary": "pleura"}
# Where each target lies, and which masks are read here (all are slow).
PLACES = {
    LUNG + "1": ("nodule", ("bronchialTree", "nodule", "pleuralBoundary", "vessels", "fissures")),
    LUNG + "2": ("nodule", ("bronchialTree", "nodule")),
    "Liver/Patient1": ("nodule", ("liver", "nodule", "portalVein")),
    "Brain/Patient1": ("globiPallidi", ("brain", "globiPallidi", "ventricles", "vessels")),
}


@cache
def read_sites(folder: Path):
    return SitesFormat.decode({path.name: path.read_bytes() for path in folder.glob("*.txt")})


@cache
def read_combined(folder: Path, masks: tuple[str, ...]) -> LabelMap:
    files = {f"{name}.nii.gz": (folder / f"{name}.nii.gz").read_bytes() for name in masks}
    names = {name: ours for name, ours in NAMES.items() if name in masks}
    parameters = combine_parameters(names=names, smallest_voxels=8, most_voxels_million=300)
    return combine_label_maps(LabelFilesFormat.decode(files), parameters)


def combined(data: Path, place: str) -> LabelMap:
    return read_combined(data / "med_rad" / place, PLACES[place][1])


def checked(data: Path, place: str):
    sites = read_sites(data / "med_rad" / place)
    return check_sites(combined(data, place), sites, CheckSitesParameters(tolerance_mm=0.3))


def itk_mask(data: Path, place: str, name: str):
    import SimpleITK as sitk

    return sitk.ReadImage(str(data / "med_rad" / place / f"{name}.nii.gz"))


@pytest.mark.parametrize("place", PLACES)
def test_targets_lie_in_what_they_aim_at_and_itk_says_so_too(place, test_data):
    target = PLACES[place][0]
    table = checked(test_data, place)
    points = table[table["kind"] == "point"]
    assert len(points) == 1 and list(points["inside"]) == [target]
    image = itk_mask(test_data, place, target)
    index = image.TransformPhysicalPointToIndex(points[["x_mm", "y_mm", "z_mm"]].to_numpy()[0])
    assert image.GetPixel(index) == 1


@pytest.mark.parametrize("place", [LUNG + "1", LUNG + "2"])
def test_starts_lie_on_the_airway(place, test_data):
    table = checked(test_data, place)
    poses = table[table["kind"] == "pose"]
    assert len(poses) == 5 and (poses["to_airway_mm"] < 0.25).all()
    assert all("airway" in at for at in poses["at"])


@pytest.mark.parametrize("place", PLACES)
def test_the_third_axis_of_a_start_points_towards_the_target(place, test_data):
    """In all twelve within 48 degrees; the first axis is off by up to 100, the second by 136."""
    sites = read_sites(test_data / "med_rad" / place)
    for pose in sites.patient_from_site:
        way = sites.points_patient_mm[0] - pose[:3, 3]
        assert pose[:3, 2] @ way / np.linalg.norm(way) > np.cos(np.deg2rad(50))


def test_a_lung_keeps_its_grid_and_every_voxel_that_nothing_covers(test_data):
    import SimpleITK as sitk

    lung = combined(test_data, LUNG + "1")
    image = itk_mask(test_data, LUNG + "1", "bronchialTree")
    assert lung.voxels.shape == image.GetSize()
    for index in ((0, 0, 0), tuple(n - 1 for n in image.GetSize())):
        place = image.TransformIndexToPhysicalPoint(index)
        np.testing.assert_allclose(lung.patient_from_index @ [*index, 1], [*place, 1], atol=1e-2)
    airway = sitk.GetArrayFromImage(image).transpose(2, 1, 0) > 0
    assert (airway >= lung.mask("airway")).all()
    assert lung.mask("airway").sum() > 0.98 * airway.sum()
    litres = (lung.voxels > 0).sum() * voxel_volume_mm3(lung.patient_from_index) / 1e6
    assert 2.5 < litres < 7
    told = lung.origin.notices
    assert any(text.startswith("pleura: ") and "ml lie under" in text for text in told)
    assert not any("another grid" in text for text in told)


def test_a_brain_comes_to_the_grid_of_its_vessels(test_data):
    brain = combined(test_data, "Brain/Patient1")
    np.testing.assert_allclose(
        np.linalg.norm(brain.patient_from_index[:3, :3], axis=0), (0.513393, 0.513393, 0.8), 1e-5
    )
    assert brain.mask("vessels").sum() == 111_459  # bit by bit, though cut to the content
    voxel_ml = voxel_volume_mm3(brain.patient_from_index) / 1000
    for name, file_ml in (("globiPallidi", 3.609), ("ventricles", 16.223)):
        assert brain.mask(name).sum() * voxel_ml == pytest.approx(file_ml, rel=0.005)
    assert sum("brought from another grid (" in text for text in brain.origin.notices) == 3


def test_a_liver_on_grids_of_other_lengths_is_copied_slice_by_slice(test_data):
    import SimpleITK as sitk

    liver = combined(test_data, "Liver/Patient1")
    assert not any("another grid" in text for text in liver.origin.notices)
    nodule = sitk.GetArrayFromImage(itk_mask(test_data, "Liver/Patient1", "nodule"))
    assert liver.mask("nodule").sum() == (nodule > 0).sum()
