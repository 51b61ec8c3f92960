"""Axes of the patient: turned arrays show the same places, and turn back."""

from itertools import permutations, product

import numpy as np
import pytest

from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.ct_scan import box_around, nearest_index, points_of, turn_of, turned_transform

TILT = np.array([[0.95, 0.1, -0.3], [-0.05, 0.99, 0.12], [0.31, -0.1, 0.94]])


@pytest.mark.parametrize("axes", list(permutations(range(3))))
@pytest.mark.parametrize("signs", list(product((1, -1), repeat=3)))
def test_every_voxel_keeps_its_place_and_axes_point_along_the_patients(axes, signs):
    transform = np.eye(4)
    transform[:3, :3] = (TILT * (1.5, 2.0, 2.5) * signs)[:, axes]
    transform[:3, 3] = (3, -4, 5)
    voxels = np.arange(3 * 4 * 5, dtype=np.int16).reshape(3, 4, 5)
    volume = Volume(voxels, transform, "HU", Origin("x"))
    turn = turn_of(transform)
    forth, moved = turn.forth(voxels), turned_transform(volume, turn)
    assert (np.diag(moved[:3, :3]) > 0).all()
    assert (np.argmax(abs(moved[:3, :3]), axis=0) == [0, 1, 2]).all()
    for index in np.ndindex(forth.shape):
        place = moved @ (*index, 1)
        before = np.rint(np.linalg.solve(transform, place)).astype(int)[:3]
        assert forth[index] == voxels[tuple(before)]
    np.testing.assert_array_equal(turn.back(forth), voxels)


def test_a_box_holds_all_voxels_between_its_corners_and_points_name_their_places():
    transform = np.eye(4)
    transform[:3, :3] = TILT * (1.5, 2.0, 2.5)
    shape, low, high = (9, 8, 7), np.array([2.0, 3, 4]), np.array([6.0, 9, 12])
    box = box_around(shape, transform, low, high)
    x, y, z = (np.broadcast_to(p, [s.stop - s.start for s in box])
               for p in points_of(shape, transform, box))  # fmt: skip
    for index in np.ndindex(shape):
        place = (transform @ (*index, 1))[:3]
        held = all(s.start <= n < s.stop for s, n in zip(box, index, strict=True))
        assert held or not ((place >= low) & (place <= high)).all()
        if held:
            local = tuple(n - s.start for n, s in zip(index, box, strict=True))
            np.testing.assert_allclose((x[local], y[local], z[local]), place, atol=1e-9)
            np.testing.assert_array_equal(nearest_index(transform, place[None]), [index])
