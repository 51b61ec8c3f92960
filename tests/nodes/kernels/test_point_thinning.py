"""Thinning against the same rule without a grid, compiled and as plain Python."""

import numpy as np
import pytest

from nodes.kernels.point_thinning import thin_points


def brute_force(points, apart):
    kept = []
    for n, point in enumerate(points):
        if all(np.linalg.norm(points[other] - point) >= apart for other in kept):
            kept.append(n)
    return kept


@pytest.mark.parametrize("call", [thin_points, thin_points.py_func], ids=["compiled", "python"])
@pytest.mark.parametrize("apart", [0.05, 0.4, 3.0])
def test_points_are_kept_in_order_unless_a_kept_one_is_near(call, apart):
    points = np.random.default_rng(1).normal(size=(250, 3)) - 0.5
    assert list(np.flatnonzero(call(points, apart))) == brute_force(points, apart)


def test_far_from_the_origin_and_in_few_places_nothing_changes():
    points = np.repeat([[1e5, -2e5, 3e4], [1e5, -2e5, 3e4 + 1]], 3, axis=0)
    assert list(thin_points(points, 0.9)) == [True, False, False, True, False, False]
    assert not len(thin_points(np.empty((0, 3)), 1.0))
