"""What the camera sees, against lines walked in small steps."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from nodes.planning.checking_boxes import make_boxes
from nodes.planning.checking_sight import are_on_surface, see_cells

ANGLE = 100.0


def look_along(view: np.ndarray, place: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.align_vectors([view], [[0, 0, 1]])[0].as_matrix()
    pose[:3, 3] = place
    return pose


def walk(occupied: np.ndarray, camera: np.ndarray, cell: np.ndarray) -> float:
    """Return how long, in cells, the line to a cell's centre runs through other occupied ones."""
    shares = (np.arange(4000) + 0.5) / 4000
    points = camera + shares[:, None] * (cell - camera)
    on = np.rint(points).astype(int)
    within = ((on >= 0) & (on < occupied.shape)).all(axis=1)
    on[~within] = 0
    blocked = np.where(within, occupied[tuple(on.T)], True) & (on != cell).any(axis=1)
    return float(blocked.sum()) / 4000 * np.linalg.norm(cell - camera)


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(bool, (5, 5, 5), elements=st.integers(0, 9).map(lambda n: n > 6)),
       hnp.arrays(float, 3, elements=st.floats(0.7, 3.3)),
       hnp.arrays(float, 3, elements=st.floats(-1, 1)))  # fmt: skip
def test_a_cell_is_seen_where_nothing_lies_before_it(occupied, camera, view) -> None:
    if np.linalg.norm(view) < 0.1 or occupied[tuple(np.rint(camera).astype(int))]:
        return
    boxes = make_boxes(occupied, np.eye(4), outside=True)
    cells = np.argwhere(occupied)
    seen = see_cells(look_along(view, camera), ANGLE, cells, boxes)
    for cell, is_seen in zip(cells, seen, strict=True):
        way = cell - camera
        cosine = way @ view / np.linalg.norm(way) / np.linalg.norm(view)
        angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
        length = walk(occupied, camera, cell)
        if abs(angle - ANGLE / 2) > 1e-6 and not 0 < length < 0.01:
            assert is_seen == (angle < ANGLE / 2 and length == 0)


def test_axes_and_size_of_cells_do_not_change_what_is_seen() -> None:
    occupied = np.ones((7, 7, 9), bool)
    occupied[1:-1, 1:-1, 1:-1] = False
    occupied[3, 3, 5] = True
    cells = np.argwhere(occupied)
    camera, view = np.array([3.2, 2.9, 1.5]), np.array([0.1, 0, 1])
    matrix = np.eye(4)
    turn = Rotation.from_rotvec([1.0, -0.4, 2.0]).as_matrix()
    matrix[:3, :3], matrix[:3, 3] = 1.7 * turn, [4, 5, 6]
    plain = see_cells(look_along(view, camera), ANGLE, cells,
                      make_boxes(occupied, np.eye(4), outside=True))  # fmt: skip
    moved = see_cells(look_along(turn @ view, matrix[:3, :3] @ camera + matrix[:3, 3]), ANGLE,
                      cells, make_boxes(occupied, matrix, outside=True))  # fmt: skip
    np.testing.assert_array_equal(plain, moved)
    assert 20 < plain.sum() < len(cells) / 2


def test_cells_of_the_surface_are_told_from_others() -> None:
    occupied = np.ones((9, 9, 9), bool)
    occupied[3:6, 3:6, 3:6] = False
    boxes = make_boxes(occupied, np.eye(4), outside=True)
    assert are_on_surface(np.array([[2, 4, 4], [6, 6, 6]]), boxes)
    for other in ([4, 4, 4], [1, 4, 4], [-5, 0, 0]):
        assert not are_on_surface(np.array([[2, 4, 4], other]), boxes)
