"""Seeds that people give, and what grows from them."""

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.imaging.ct_scan import CtScan
from nodes.imaging.region_growing import grow_below, seeds_in_tissue

TRANSFORM = np.array([[2.0, 0, 0, -10], [0, 2.0, 0, -10], [0, 0, 3.0, 50], [0, 0, 0, 1]])


def scan(closed=None):
    hu = np.full((10, 10, 10), 40, np.int16)
    hu[2:5] = -900
    hu[6:9] = -900
    return CtScan(hu, TRANSFORM, np.zeros(hu.shape, bool) if closed is None else closed)


def test_a_region_stays_on_its_side_of_a_wall():
    grown = grow_below(scan().hu, np.array([[3, 4, 5]]), -500.0)
    expected = np.zeros((10, 10, 10), bool)
    expected[2:5] = True
    np.testing.assert_array_equal(grown, expected)


def test_a_seed_is_the_voxel_that_it_lies_in():
    seeds = seeds_in_tissue(scan(), ((-4.2, 0.9, 61.0),), (-1000.0, -500.0), "airway")
    assert seeds.tolist() == [[3, 5, 4]]


@pytest.mark.parametrize(
    ("point", "words"),
    [
        ((-4.0, 0.0, 40.0), r"outside of the image\n.*\[-10.0, -10.0, 50.0\] to \[8.0,"),
        ((0.0, 0.0, 62.0), "40 HU there"),
    ],
)
def test_a_seed_that_cannot_be_is_refused_with_what_is_there(point, words):
    with pytest.raises(BadInput, match=words):
        seeds_in_tissue(scan(), (point,), (-1000.0, -500.0), "airway")


def test_a_seed_in_a_barrier_is_refused():
    closed = np.zeros((10, 10, 10), bool)
    closed[3, 5, 4] = True
    with pytest.raises(BadInput, match="in a barrier"):
        seeds_in_tissue(scan(closed), ((-4.0, 0.0, 62.0),), (-1000.0, -500.0), "airway")
