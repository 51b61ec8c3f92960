"""Tips in cells, against looking at many places along each."""

import numpy as np
import pytest

from nodes.environment.needle_space import NeedleSpace
from nodes.environment.needle_tips import tips_in_cells

CELL, SHIFT = 1.5, np.array([2.0, -1.0, 0.7])


def space(cells):
    cell_from_grid = np.diag([1 / CELL] * 3 + [1.0])
    cell_from_grid[:3, 3] = SHIFT
    nothing = np.zeros((1, 1, 1))
    return NeedleSpace(nothing.astype(np.uint8), nothing.astype(bool), nothing.astype(np.float32),
                       np.ones(3), (slice(0), slice(0), slice(0)), np.zeros(3), np.eye(4), "free",
                       cells, cell_from_grid)  # fmt: skip


@pytest.mark.parametrize("depth", [0.0, 1.0, 5.0, 9.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_tip_is_in_the_part_where_all_places_behind_the_first_diagonal_are(seed, depth):
    random = np.random.default_rng(seed)
    cells = random.random((9, 8, 7)) < 0.9
    pleura = random.uniform(-4, 12, (600, 3))
    direction = random.normal(size=(600, 3))
    direction[:200] = np.eye(3)[random.integers(0, 3, 200)] * random.choice([-1, 1], (200, 1))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    found = tips_in_cells(pleura, direction, space(cells), depth)
    first = min(depth, CELL * 3**0.5)
    ways = np.linspace(first, depth, 4000 if depth > first else 1)
    for tip, start, along in zip(found, pleura, direction, strict=True):
        places = (start + ways[:, None] * along) / CELL + SHIFT
        index = np.rint(places).astype(int)
        inside = ((index >= 0) & (index < cells.shape)).all(axis=1)
        told = inside.all() and cells[tuple(index.T)].all()
        if told != tip:  # a corner may be cut for less than the places are apart
            assert told and not tip
            edges = np.sort(abs(places - np.rint(places)), axis=1)[:, 1]
            assert edges.max() > 0.5 - 0.01
    assert found.any() and not found.all()


def test_no_tips_give_no_answers():
    assert tips_in_cells(np.empty((0, 3)), np.empty((0, 3)), space(np.ones((1, 1, 1), bool)),
                         5.0).shape == (0,)  # fmt: skip
