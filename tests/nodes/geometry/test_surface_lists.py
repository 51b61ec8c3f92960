"""Lists hold each free face of each wanted cell once, and boxes hold their cells."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from nodes.geometry.lines_of_sight import find_surface
from nodes.geometry.surface_lists import list_blocks, list_faces
from tests.nodes.geometry.made_surfaces import seeded_grids, to_grid


def entries(lists):
    """Return (cell, face) of all entries, and check places and boxes on the way."""
    found = []
    for n, (start, count) in enumerate(zip(lists.starts, lists.counts, strict=True)):
        assert count > 0
        centres = lists.centres[:, start : start + count]
        low, high = (
            lists.middles[:, n] - lists.halves[:, n],
            lists.middles[:, n] + lists.halves[:, n],
        )
        np.testing.assert_array_equal(low, centres.min(axis=1))
        np.testing.assert_array_equal(high, centres.max(axis=1))
        found += [(int(cell), int(lists.faces[n])) for cell in lists.members[start : start + count]]
    return found


@given(seeded_grids(), st.integers(1, 6), st.integers(1, 3))
def test_each_free_face_of_each_wanted_cell_is_in_one_list(made, size, parts):
    free, rng = made
    surface = find_surface(to_grid(free, corners=True))
    wanted = np.flatnonzero(rng.random(len(surface.cells)) < 0.7)
    found = []
    for part in range(parts):
        lists = list_faces(surface.cells, surface.free, wanted, size, (part, parts))
        found += entries(lists)
        cells = surface.cells[lists.members].T
        np.testing.assert_array_equal(lists.centres, cells * 65536 + 32768)
    expected = set()
    for number in wanted.tolist():
        for face in range(6):
            beside = surface.cells[number].copy()
            beside[face % 3] += 1 if face > 2 else -1
            inside = (beside >= 0).all() and (beside < free.shape).all()
            if inside and free[tuple(beside)]:
                expected.add((number, face))
    assert len(found) == len(set(found)) and set(found) == expected


@given(seeded_grids(), st.integers(1, 6))
def test_blocks_hold_each_cell_once_and_near_ones_together(made, size):
    surface = find_surface(to_grid(made[0]))
    lists = list_blocks(surface.cells, size)
    assert sorted(cell for cell, _ in entries(lists)) == list(range(len(surface.cells)))
    assert (lists.halves < size * 32768).all()
