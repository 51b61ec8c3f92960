"""Ways: how they are traced, measured and put together."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nodes.planning.plan_paths import (
    Path,
    places_along,
    trace_back,
    turns_between,
    way_lengths,
)


def path_of(values, corners):
    """Return a way of one needle that gets longer, and does not turn."""
    count = len(values)
    lengths = np.array(values, float)[:, None]
    return Path(
        np.repeat(np.eye(3)[None, None], count, 0),
        lengths,
        np.repeat(lengths[..., None], 6, 2),
        np.array(corners),
    )


def test_a_node_is_traced_back_to_the_start():
    parents = np.array([-1, 0, 0, 1, 3, 2])
    assert trace_back(parents, 4).tolist() == [0, 1, 3, 4]
    assert trace_back(parents, 0).tolist() == [0]


def test_a_piece_takes_the_place_of_what_is_between_its_ends():
    path = path_of([0, 1, 2, 3, 4, 5], [0, 2, 4, 5])
    piece = path_of([1, 1.5, 4], [0, 2])
    new = path.replaced(1, 4, piece)
    assert new.lengths_mm[:, 0].tolist() == [0, 1, 1.5, 4, 5]
    assert new.corners.tolist() == [0, 1, 3, 4]
    assert new.wrenches[:, 0, 0].tolist() == [0, 1, 1.5, 4, 5]


def test_a_way_that_ends_earlier_has_its_corner_there():
    path = path_of([0, 1, 2, 3], [0, 1, 3])
    assert path.until(2).corners.tolist() == [0, 1, 2]
    assert path.until(0).corners.tolist() == [0]
    assert len(path.until(2).lengths_mm) == 3


def test_lengths_of_ways_are_those_of_turns_times_the_lever_and_of_changed_lengths():
    turn = Rotation.from_rotvec([0.3, 0.0, 0.0]).as_matrix()
    starts, ends = np.eye(3)[None, None], turn[None, None]
    length = way_lengths(starts, ends, np.array([[5.0]]), np.array([[9.0]]), 10.0)
    assert length[0] == pytest.approx(5.0)  # 3 and 4
    assert turns_between(starts, ends)[0, 0] == pytest.approx([0.3, 0, 0])


def test_places_along_a_way_add_up():
    assert places_along(path_of([0, 2, 3, 7], [0, 3]), 1.0).tolist() == [0, 2, 3, 7]
