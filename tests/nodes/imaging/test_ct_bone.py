"""Bone up to its half height, with its marrow, and without the spinal canal."""

import numpy as np
import pytest

from nodes.imaging.ct_bone import find_bone
from nodes.imaging.ct_scan import CtScan
from tests.nodes.imaging.made_chest import parameters

STEP = 1.0


def scan_of(hu, thickness=STEP):
    return CtScan(
        np.rint(hu).astype(np.int16),
        np.diag([STEP, STEP, thickness, 1.0]),
        np.zeros(hu.shape, bool),
    )


def found(hu, thickness=STEP):
    return find_bone(scan_of(hu, thickness), np.ones(hu.shape, bool), parameters())


def grid(size=48):
    axis = np.arange(size) - size / 2 + 0.5
    return axis[:, None, None], axis[None, :, None], axis[None, None, :]


@pytest.mark.parametrize("cortex_hu", [500, 900, 1400])
def test_a_blurred_tube_has_its_own_volume_whatever_its_density(cortex_hu):
    from scipy import ndimage

    x, y, _ = grid()
    away = np.broadcast_to(np.hypot(x, y), (48, 48, 48))
    hu = np.where(away < 9, cortex_hu, 40.0)
    hu[away < 5] = 150
    bone = found(ndimage.gaussian_filter(hu, 1.0))
    assert bone.sum() == pytest.approx((away < 9).sum(), rel=0.05)


def test_fatty_marrow_in_a_closed_bone_counts_as_bone():
    x, y, z = grid()
    away = np.sqrt(x**2 + y**2 + z**2)
    hu = np.where(away < 14, 800.0, 40.0)
    hu[away < 11] = -60
    np.testing.assert_array_equal(found(hu), away < 14)


def test_a_canal_through_bone_stays_open_and_a_skull_hollow():
    x, y, z = grid()
    away = np.broadcast_to(np.hypot(x, y), (48, 48, 48))
    canal = np.where(away < 14, 800.0, 40.0)
    canal[away < 8] = 25
    assert not found(canal)[away < 7].any()
    skull = np.sqrt(x**2 + y**2 + z**2)
    hu = np.where(skull < 23, 800.0, 40.0)
    hu[skull < 20] = 35
    values = parameters(largest_marrow_mm2=500.0)
    assert not find_bone(scan_of(hu), np.ones(hu.shape, bool), values)[skull < 10].any()


def test_small_calcifications_are_dropped():
    hu = np.full((30, 30, 30), 40.0)
    hu[10:18, 10:18, 10:18] = 600  # half a millilitre
    assert not found(hu).any()


@pytest.mark.parametrize("slices", [3, 5])  # odd: no voxel is half full, which is either
def test_thick_slices_show_slanting_bones_in_their_own_volume(slices):
    """Two ribs that cross the slices at a slant: most of their voxels hold them in part."""
    x, y, z = grid(60)
    hu, true = np.full((60, 60, 60), 40.0), np.zeros((60, 60, 60), bool)
    for side in (-14, 14):
        away = np.hypot(x - side, (y - 2 * z) / np.hypot(1, 2))
        true |= away < 6
        hu[away < 6] = 1000
    thick = hu.reshape(60, 60, -1, slices).mean(axis=3)
    assert found(thick, slices).sum() * slices == pytest.approx(true.sum(), rel=0.03)


@pytest.mark.parametrize("slices", [4, 5])
def test_thick_slices_do_not_bridge_the_disc_between_two_vertebrae(slices):
    x, y, z = grid(60)
    disc = abs(z) < 5
    column = np.hypot(x, y) < 15
    hu = np.where(column & ~disc, 400.0, 40.0)
    thick = hu.reshape(60, 60, -1, slices).mean(axis=3)
    middle = thick[30, 30] < 60  # slices that hold nothing but disc
    assert middle.any()
    assert not found(thick, slices)[:, :, middle].any()
