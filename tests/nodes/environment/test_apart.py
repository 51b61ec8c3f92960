"""Labels that never communicate: no way over faces leads from one to the other."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from nodes.environment.build_occupancy_grid import build_occupancy_grid
from nodes.environment.parameters import BuildOccupancyGridParameters
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin

LUNGS = ("left_lung", "right_lung")


def parameters(size, free=LUNGS, apart=(LUNGS,)):
    return BuildOccupancyGridParameters(
        free_labels=free, apart=apart, voxel_size_mm=size, neighbourhood="faces",
        inside_patient_mm=(), smallest_part_ml=0.0, volume_tolerance=1.0,
    )  # fmt: skip


def label_map(voxels, spacing=(1.0, 1.0, 1.0)):
    names = ("left_lung", "right_lung", "effusion")
    voxels = np.ascontiguousarray(voxels, np.uint8)
    return LabelMap(voxels, np.diag([*spacing, 1.0]), names, Origin("test"))


def boxes():
    """Two boxes of 10 x 8 x 8 voxels side by side along x."""
    voxels = np.zeros((24, 12, 12))
    voxels[2:12, 2:10, 2:10], voxels[12:22, 2:10, 2:10] = 1, 2
    return voxels


def walls(grid):
    return [n for n in grid.origin.notices if "touch" in n]


def is_free(grid):
    return (grid.voxels > 0) & ~grid.mask("boundary")


def test_two_boxes_that_touch_are_two_parts_and_the_wall_is_told():
    grid, table = build_occupancy_grid(label_map(boxes()), parameters(1.0))
    assert grid.names == ("free", "boundary", "part_2")
    # one layer of cells on either side of the face where they touch
    assert list(table.cells) == [9 * 8 * 8, 9 * 8 * 8]
    assert set(table.label) == set(LUNGS)
    assert walls(grid) == ["left_lung and right_lung touch: 128 cells between them (0.128 ml)"
                           " are a wall"]  # fmt: skip


def test_a_cell_that_is_half_of_each_is_the_wall():
    """Cells of 4 mm over 20 mm: the middle one of five holds as much of either box."""
    grid, table = build_occupancy_grid(label_map(boxes()), parameters(4.0))
    assert list(table.cells) == [2 * 2 * 2, 2 * 2 * 2]
    assert len(walls(grid)) == 1 and "4 cells" in walls(grid)[0]


@pytest.mark.parametrize("size", [0.7, 1.0, 1.5, 4.0])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_mirrored_image_has_the_mirrored_wall(size, axis):
    voxels = boxes()
    voxels[12:15, 2:6, 2:10] = 1  # a step, so that the border is no plane
    straight, _ = build_occupancy_grid(label_map(voxels), parameters(size))
    mirrored, _ = build_occupancy_grid(label_map(np.flip(voxels, axis)), parameters(size))
    np.testing.assert_array_equal(np.flip(is_free(mirrored), axis), is_free(straight))
    named = np.array([0, 2, 1])[voxels.astype(int)]
    swapped, _ = build_occupancy_grid(label_map(named), parameters(size))
    np.testing.assert_array_equal(is_free(swapped), is_free(straight))


@settings(max_examples=60, deadline=None)
@given(
    arrays(np.uint8, st.tuples(*[st.integers(1, 6)] * 3), elements=st.integers(0, 2)),
    st.sampled_from([1.0, 2.0, 3.0]),
)
def test_no_part_has_cells_of_both_labels(voxels, size):
    """Cells of whole voxels, each of the label that most of its voxels have."""
    try:
        grid, _ = build_occupancy_grid(label_map(voxels), parameters(size))
    except BadInput:
        return
    parts, count = ndimage.label(is_free(grid))
    index = np.indices(grid.voxels.shape).reshape(3, -1).T
    centres = index * size + grid.patient_from_index[:3, 3]
    shares = np.stack([_share(voxels == n, centres, size) for n in (1, 2)])
    shares = shares.reshape(2, *grid.voxels.shape)
    for part in range(1, count + 1):
        mine = shares[:, parts == part]
        assert not ((mine[0] > mine[1] + 1e-4).any() and (mine[1] > mine[0] + 1e-4).any())


def _share(mask, centres, size):
    """Share of each cube that boxes of 1 mm fill, one by one."""
    share = np.zeros(len(centres))
    for box in np.argwhere(mask):
        overlap = np.minimum(centres + size / 2, box + 0.5) - np.maximum(
            centres - size / 2, box - 0.5
        )
        share += np.clip(overlap, 0, None).prod(axis=1)
    return share / size**3


def test_pairs_that_are_not_both_free_or_do_not_touch_change_nothing():
    voxels = boxes()
    for pair, free in (((), LUNGS), ((("left_lung", "effusion"),), LUNGS),
                       ((LUNGS,), ("left_lung",))):  # fmt: skip
        with_pair, _ = build_occupancy_grid(label_map(voxels), parameters(1.0, free, pair))
        without, _ = build_occupancy_grid(label_map(voxels), parameters(1.0, free, ()))
        np.testing.assert_array_equal(with_pair.voxels, without.voxels)
        assert not walls(with_pair)
    voxels[11:13] = 0
    grid, _ = build_occupancy_grid(label_map(voxels), parameters(1.0))
    assert not walls(grid) and is_free(grid).sum() == 2 * 9 * 64


@pytest.mark.parametrize("size", [1.0, 1.5])
def test_two_lungs_that_meet_before_the_heart_are_one_part_each(size):
    """Ellipsoids that overlap at the front of the midline, cut where they meet, in 0.8 x 2 mm."""
    spacing = np.array([0.8, 0.8, 2.0])
    x, y, z = np.moveaxis(np.stack(np.indices((150, 100, 40)), axis=-1) * spacing, -1, 0)
    inside = [
        ((x - middle) / 32) ** 2 + ((y - 40) / 38) ** 2 + ((z - 40) / 36) ** 2 < 1
        for middle in (30, 90)
    ]
    voxels = np.select([inside[0] & (x < 60), inside[1] & (x > 60)], [1, 2])
    labels = label_map(voxels, spacing)
    joined, _ = build_occupancy_grid(labels, parameters(size, apart=()))
    assert joined.names == ("free", "boundary")
    grid, table = build_occupancy_grid(labels, parameters(size))
    assert list(table.name) == ["free", "part_2"] and set(table.label) == set(LUNGS)
    middle_x = {row.label: row.centre_x_mm for row in table.itertuples()}
    assert middle_x["left_lung"] < 60 < middle_x["right_lung"]
    lost = is_free(joined).sum() - is_free(grid).sum()
    assert 0 < lost * size**3 < 0.02 * np.count_nonzero(voxels) * spacing.prod()
    for one, other in combinations(("free", "part_2"), 2):
        assert not (ndimage.binary_dilation(grid.mask(one)) & grid.mask(other)).any()
