"""Masks on other grids: exact where nothing is in between, true to volume and place elsewhere."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage
from scipy.spatial.transform import Rotation

from nodes.geometry import regridding
from nodes.geometry.regridding import (
    Grid,
    count_outside,
    index_extent,
    regrid_mask,
    same_grid,
    same_lattice,
)

TOLERANCE = 0.01
small_masks = arrays(bool, st.tuples(*[st.integers(1, 5)] * 3))
anything = settings(max_examples=40, deadline=None)


def affine(step=(1.0, 1.0, 1.0), angles_deg=(0.0, 0.0, 0.0), start=(0.0, 0.0, 0.0)) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", angles_deg, degrees=True).as_matrix() * step
    matrix[:3, 3] = start
    return matrix


def grid_around(matrix: np.ndarray, half_mm: float) -> Grid:
    """A grid with these axes whose middle is the patient's zero point."""
    step = np.linalg.norm(matrix[:3, :3], axis=0)
    shape = tuple(int(n) for n in 2 * np.ceil(half_mm / step) + 1)
    centred = matrix.copy()
    centred[:3, 3] = -matrix[:3, :3] @ ((np.array(shape) - 1) / 2)
    return Grid(centred, shape)


def places(grid: Grid) -> np.ndarray:
    index = np.moveaxis(np.indices(grid.shape), 0, -1)
    return index @ grid.patient_from_index[:3, :3].T + grid.patient_from_index[:3, 3]


def ball(grid: Grid, radius_mm: float, centre_mm=(0.0, 0.0, 0.0)) -> np.ndarray:
    return np.linalg.norm(places(grid) - centre_mm, axis=-1) <= radius_mm


def on_whole_grid(mask: np.ndarray, matrix: np.ndarray, grid: Grid) -> np.ndarray:
    result = np.zeros(grid.shape, bool)
    box, inside = regrid_mask(mask, matrix, grid, TOLERANCE)
    result[box] = inside
    return result


GRIDS = {
    "turned": affine((0.7, 0.7, 0.7), (20, -35, 50)),
    "anisotropic": affine((0.6, 0.9, 2.0), (5, 10, -15)),
    "mirrored": affine((-0.8, 0.7, 1.1), (0, 40, 0)),
    "coarse": affine((3.0, 2.5, 2.0), (10, 20, 30)),
}


@pytest.mark.parametrize("name", GRIDS)
def test_a_ball_keeps_volume_and_place_on_turned_and_anisotropic_grids(name):
    """Means over eight places, since one ball on one grid is off by how the voxels happen to fall.

    A share is the mask blurred, and a blurred ball is 0.5 a little inside of its surface: by the
    blur's variance over the radius. Linear interpolation blurs by step^2 / 6, a larger voxel of the
    target by step^2 / 12.
    """
    source = grid_around(affine((0.8, 1.0, 1.5), (7, 3, 12)), 20)
    target, radius = grid_around(GRIDS[name], 22), 15.0
    blur = np.mean([0.8**2, 1.0**2, 1.5**2]) / 6
    if name == "coarse":
        blur += np.mean([3.0**2, 2.5**2, 2.0**2]) / 12
    voxel = abs(np.linalg.det(target.patient_from_index[:3, :3]))
    volumes, errors = [], []
    for centre in np.random.default_rng(0).uniform(-2, 2, (8, 3)):
        laid = on_whole_grid(ball(source, radius, centre), source.patient_from_index, target)
        volumes.append(laid.sum() * voxel)
        errors.append(places(target)[laid].mean(axis=0) - centre)
    expected = 4 / 3 * np.pi * (radius - blur / radius) ** 3
    assert np.mean(volumes) == pytest.approx(expected, rel=0.004)
    np.testing.assert_allclose(np.mean(errors, axis=0), 0, atol=0.03)


@pytest.mark.parametrize("name", ["turned", "anisotropic", "mirrored"])
def test_scipy_finds_the_same_voxels(name):
    rng = np.random.default_rng(3)
    smooth = ndimage.gaussian_filter(rng.random((24, 20, 16)), 2)
    mask = smooth > np.median(smooth)
    matrix = affine((2.1, 2.2, 2.3), (12, -8, 30), (4, 5, 6))
    target = Grid(GRIDS[name] + affine(start=(10, 3, 20)) - np.eye(4), (40, 45, 30))
    relative = np.linalg.inv(matrix) @ target.patient_from_index
    share = ndimage.affine_transform(
        np.pad(mask, 1).astype(float), relative[:3, :3], relative[:3, 3] + 1, target.shape, order=1
    )
    laid = on_whole_grid(mask, matrix, target)
    clear = abs(share - 0.5) > 1e-3  # elsewhere it is a tie
    assert 0.05 < laid.mean() < 0.95 and clear.mean() > 0.99
    np.testing.assert_array_equal(laid[clear], share[clear] >= 0.5)


def test_larger_voxels_hold_the_mean_of_what_lies_in_them():
    rng = np.random.default_rng(0)
    mask = np.repeat(np.repeat(np.repeat(rng.random((6, 5, 4)) < 0.5, 3, 0), 3, 1), 3, 2)
    mask ^= rng.random(mask.shape) < 0.2
    target = Grid(affine((3.0, 3.0, 3.0), start=(1.0, 1.0, 1.0)), (6, 5, 4))
    expected = mask.reshape(6, 3, 5, 3, 4, 3).sum(axis=(1, 3, 5)) >= 14  # of 27: no ties
    np.testing.assert_array_equal(on_whole_grid(mask, np.eye(4), target), expected)


@anything
@given(
    small_masks,
    st.permutations(range(3)),
    arrays(bool, 3),
    arrays(int, 3, elements=st.integers(-3, 3)),
)
def test_any_order_and_direction_of_axes_copies_voxel_by_voxel(mask, axes, flips, shift):
    """The same voxels, stored in another order and cut elsewhere, need no interpolation."""
    step = np.array([0.7, 1.3, 2.9])
    stored = np.flip(mask.transpose(axes), np.flatnonzero(flips))
    matrix = np.zeros((4, 4))
    matrix[3, 3] = 1
    for place, axis in enumerate(axes):
        matrix[axis, place] = -step[axis] if flips[place] else step[axis]
        matrix[axis, 3] = (mask.shape[axis] - 1) * step[axis] if flips[place] else 0
    target = Grid(affine(step, start=shift * step), (9, 9, 9))
    expected = np.zeros((15, 15, 15), bool)
    expected[3 : 3 + mask.shape[0], 3 : 3 + mask.shape[1], 3 : 3 + mask.shape[2]] = mask
    i, j, k = shift + 3
    np.testing.assert_array_equal(
        on_whole_grid(stored, matrix, target), expected[i : i + 9, j : j + 9, k : k + 9]
    )


@pytest.mark.parametrize("axis", range(3))
def test_a_plate_halfway_between_voxels_keeps_its_thickness(axis):
    """Both faces are ties: one falls inside, the other outside. At the plate's rim, where ties of
    several axes meet, a corner may be lost."""
    mask = np.zeros((9, 9, 9), bool)
    np.moveaxis(mask, axis, 0)[4:6] = True
    shift = np.zeros(3)
    shift[axis] = 0.5
    laid = on_whole_grid(mask, np.eye(4), Grid(affine(start=shift), (9, 9, 9)))
    assert (laid.sum(axis=axis)[1:-1, 1:-1] == 2).all()


def test_slabs_make_no_seam(monkeypatch):
    source = grid_around(affine((0.8, 1.0, 1.5), (7, 3, 12)), 12)
    mask, target = ball(source, 9), grid_around(GRIDS["coarse"], 14)
    whole = on_whole_grid(mask, source.patient_from_index, target)
    monkeypatch.setattr(regridding, "SLAB_VOXELS", 50)
    np.testing.assert_array_equal(
        on_whole_grid(mask, source.patient_from_index, target), whole, strict=True
    )


def test_a_mask_beside_the_grid_gives_an_empty_box():
    box, inside = regrid_mask(
        np.ones((3, 3, 3), bool),
        affine((1, 1, 1.5), start=(50, 0, 0)),
        Grid(np.eye(4), (4, 4, 4)),
        0.01,
    )
    assert inside.size == 0 and np.zeros((4, 4, 4))[box].size == 0


def test_voxels_at_the_edge_of_the_array_reach_half_a_step_beyond_their_centre():
    fine = Grid(affine((0.1, 1, 1), start=(-2.0, 0, 0)), (60, 1, 1))
    laid = on_whole_grid(np.ones((2, 1, 1), bool), np.eye(4), fine)[:, 0, 0]
    x = -2.0 + 0.1 * np.arange(60)
    clear = abs(abs(x - 0.5) - 1) > 1e-6
    np.testing.assert_array_equal(laid[clear], (abs(x - 0.5) < 1)[clear])


def test_grids_are_the_same_to_the_rounding_of_headers_only():
    shape = (497, 331, 512)
    a = Grid(affine((0.55078125, 0.55078125, 0.7000196)), shape)
    assert same_grid(a, Grid(affine((0.55078125, 0.55078125, 0.7000122)), shape), TOLERANCE)
    assert not same_grid(a, Grid(affine((0.55078125, 0.55078125, 0.70005)), shape), TOLERANCE)
    assert not same_grid(
        a, Grid(affine((0.55078125, 0.55078125, 0.7000196), (0, 0, 0.01)), shape), TOLERANCE
    )
    assert not same_grid(a, Grid(a.patient_from_index, (497, 331, 511)), TOLERANCE)


def test_a_cut_out_lies_on_the_lattice_of_the_whole_but_is_another_grid():
    whole = Grid(affine((1, 2, 3), (10, 20, 30), (4, 5, 6)), (9, 9, 9))
    start = whole.patient_from_index @ [2, 3, 4, 1]
    cut = Grid(affine((1, 2, 3), (10, 20, 30), start[:3]), (3, 3, 3))
    assert same_lattice(whole, cut, TOLERANCE) and not same_grid(whole, cut, TOLERANCE)
    between = Grid(affine((1, 2, 3), (10, 20, 30), start[:3] + 0.3), (3, 3, 3))
    assert not same_lattice(whole, between, TOLERANCE)


def test_a_single_slice_is_as_thick_as_its_voxels():
    """Its centres lie on the finer lattice, its voxels do not."""
    thick = affine((1, 1, 5))
    grid = Grid(np.eye(4), (6, 6, 12))
    assert not same_lattice(grid, Grid(thick, (6, 6, 1)), TOLERANCE)
    box, inside = regrid_mask(
        np.ones((4, 4, 1), bool), thick @ affine(start=(1, 1, 1)), grid, TOLERANCE
    )
    planes = np.flatnonzero(inside.any(axis=(0, 1))) + box[2].start
    assert list(planes) == [3, 4, 5, 6, 7]


def test_the_extent_holds_whole_voxels():
    low, high = index_extent(np.linalg.inv(affine((2, 2, 2))), Grid(np.eye(4), (4, 6, 8)))
    np.testing.assert_allclose(low, -0.25)
    np.testing.assert_allclose(high, [1.75, 2.75, 3.75])


@pytest.mark.parametrize("name", GRIDS)
def test_what_lies_outside_is_counted_voxel_by_voxel(name):
    mask = np.random.default_rng(1).random((9, 8, 7)) < 0.5
    matrix = affine((1.1, 0.9, 1.3), (30, 5, 60), (-3, -2, -1))
    grid = Grid(GRIDS[name], (6, 5, 4))
    centres = np.argwhere(mask) @ matrix[:3, :3].T + matrix[:3, 3]
    index = (centres - grid.patient_from_index[:3, 3]) @ np.linalg.inv(
        grid.patient_from_index[:3, :3]
    ).T
    inside = ((np.rint(index) >= 0) & (np.rint(index) < grid.shape)).all(axis=1)
    assert 0 < inside.sum() < len(inside)
    assert count_outside(mask, matrix, grid) == (~inside).sum()
    assert count_outside(mask, matrix, grid_around(matrix, 40)) == 0
