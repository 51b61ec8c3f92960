"""Sites in an anatomy: the label they lie in, and distances against brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from catalog.formats.table import TableFormat
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.geometry.sites import Sites
from nodes.imaging.check_sites import check_sites
from nodes.imaging.parameters import CheckSitesParameters

TOLERANCE = CheckSitesParameters(tolerance_mm=1.0)


def label_map(voxels, names, matrix=None) -> LabelMap:
    matrix = np.eye(4) if matrix is None else matrix
    return LabelMap(np.asarray(voxels, np.uint8), matrix, names, Origin("test"))


def points(*places) -> Sites:
    names = tuple(f"p{n}" for n in range(len(places)))
    return Sites(point_names=names, points_patient_mm=np.array(places, float).reshape(-1, 3))


def tube() -> LabelMap:
    """An airway of 3 x 3 voxels along z, in a lung with an edge of nothing."""
    voxels = np.zeros((11, 11, 8), np.uint8)
    voxels[1:10, 1:10] = 2
    voxels[4:7, 4:7] = 1
    return label_map(voxels, ("airway", "lung"))


def test_a_site_is_in_the_label_of_its_voxel():
    table = check_sites(tube(), points((5, 5, 3), (2, 5, 3), (0, 0, 0), (-0.6, 5, 3)), TOLERANCE)
    assert list(table["inside"]) == ["airway", "lung", "background", "outside"]


def test_distances_end_at_the_faces_of_voxels():
    table = check_sites(
        tube(), points((5, 5, 3), (2.5, 5, 3), (5, 5, 12), (-3.5, 0.5, 3)), TOLERANCE
    )
    np.testing.assert_allclose(table["to_airway_mm"], [0, 1, 4.5, np.hypot(7, 3)])
    np.testing.assert_allclose(table["to_lung_mm"], [1.5, 0, np.hypot(1.5, 4.5), 4])
    assert list(table["at"]) == ["airway", "lung, airway", "", ""]


def test_poses_come_first_and_tell_their_place():
    pose = np.eye(4)
    pose[:3, 3] = (5, 5, 3)
    sites = Sites(("start",), pose[None], ("target",), np.array([[2.0, 5.0, 3.0]]))
    table = check_sites(tube(), sites, TOLERANCE)
    assert list(table["site"]) == ["start", "target"] and list(table["kind"]) == ["pose", "point"]
    np.testing.assert_array_equal(table[["x_mm", "y_mm", "z_mm"]], [[5, 5, 3], [2, 5, 3]])


@settings(max_examples=40, deadline=None)
@given(
    arrays(np.uint8, (4, 5, 3), elements=st.integers(0, 2)),
    arrays(float, 3, elements=st.floats(-9, 9)),
    arrays(float, 3, elements=st.floats(-180, 180)),
)
def test_distances_are_those_of_brute_force_on_any_grid(voxels, place, angles):
    step = np.array([0.5, 1.0, 2.0])
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", angles, degrees=True).as_matrix() * step
    matrix[:3, 3] = (1, -2, 3)
    table = check_sites(label_map(voxels, ("a", "b"), matrix), points(place), TOLERANCE)
    for label, name in enumerate("ab", start=1):
        told = table[f"to_{name}_mm"][0]
        centres = np.argwhere(voxels == label)
        if not len(centres):
            assert np.isnan(told)
            continue
        # A dense sample of each voxel, its faces included, in the patient frame.
        side = np.linspace(-0.5, 0.5, 9)
        offsets = np.stack(np.meshgrid(side, side, side), axis=-1).reshape(-1, 3)
        samples = (centres[:, None] + offsets).reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        nearest = np.linalg.norm(samples - place, axis=1).min()
        assert told <= nearest + 1e-9
        assert told >= nearest - np.linalg.norm(step) / 16 - 1e-9


def test_no_sites_and_no_labels_give_an_empty_table_that_can_be_kept():
    for anatomy in (tube(), label_map(np.zeros((2, 2, 2)), ())):
        table = check_sites(anatomy, Sites(), TOLERANCE)
        assert len(table) == 0 and list(table.columns)[:2] == ["site", "kind"]
        back = TableFormat.decode(TableFormat.encode(table))
        assert list(back.columns) == list(table.columns)


def test_the_table_survives_the_store():
    table = check_sites(tube(), points((5, 5, 3), (2, 5, 3), (-9, 0, 0)), TOLERANCE)
    back = TableFormat.decode(TableFormat.encode(table))
    assert back.equals(table)


def test_a_label_without_voxels_has_no_distance():
    table = check_sites(label_map(np.zeros((3, 3, 3)), ("nodule",)), points((1, 1, 1)), TOLERANCE)
    assert np.isnan(table["to_nodule_mm"][0]) and table["at"][0] == ""


@pytest.mark.parametrize("tolerance_mm", [0.0, 0.5, 2.0])
def test_the_tolerance_says_what_is_at_a_label(tolerance_mm):
    table = check_sites(
        tube(), points((2.5, 5, 3)), CheckSitesParameters(tolerance_mm=tolerance_mm)
    )
    assert ("airway" in table["at"][0]) == (tolerance_mm >= 1)
