"""Cells next to a mask, and areas of smooth boundaries, against counting and formulas."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.environment.free_parts import boundary_of, main_labels, measure_parts
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin


@settings(max_examples=40, deadline=None)
@given(
    arrays(bool, st.tuples(*[st.integers(1, 5)] * 3)),
    st.sampled_from([("faces", 1), ("edges", 2), ("corners", 3)]),
)
def test_next_to_a_mask_is_what_a_step_reaches(mask, kind):
    name, most = kind
    expected = set()
    for place in np.argwhere(mask):
        for step in product((-1, 0, 1), repeat=3):
            other = place + step
            inside = (other >= 0).all() and (other < mask.shape).all()
            if inside and sum(map(abs, step)) <= most and not mask[tuple(other)]:
                expected.add(tuple(other))
    assert set(map(tuple, np.argwhere(boundary_of(mask, name)))) == expected


def test_a_cylinders_row_has_its_volume_area_and_centre_on_a_turned_grid():
    index = np.stack(np.indices((60, 60, 40)), axis=-1) - [29.5, 29.5, 19.5]
    share = (np.linalg.norm(index[..., :2], axis=-1) < 20) & (abs(index[..., 2]) < 15)
    matrix = np.array([[0, 0, 2.0, 5], [2.0, 0, 0, 6], [0, -2.0, 0, 7], [0, 0, 0, 1]])
    table = measure_parts(share.astype(np.uint8), share.astype(np.float32), ("free", "boundary"),
                          matrix, "faces")  # fmt: skip
    (row,) = table.to_dict("records")
    assert row["volume_ml"] == pytest.approx(np.pi * 40**2 * 60 / 1000, rel=0.01)
    area_mm2 = 2 * np.pi * 40**2 + 2 * np.pi * 40 * 60
    assert row["boundary_area_cm2"] == pytest.approx(area_mm2 / 100, rel=0.03)
    centre = matrix @ [29.5, 29.5, 19.5, 1]
    assert [row[f"centre_{a}_mm"] for a in "xyz"] == pytest.approx(list(centre[:3]))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_a_part_has_the_label_that_most_of_its_cells_centres_lie_in(seed):
    random = np.random.default_rng(seed)
    voxels = random.integers(0, 4, (6, 5, 4)).astype(np.uint8)
    labels = random.integers(0, 5, (9, 8, 7)).astype(np.uint8)
    grid = LabelMap(voxels, np.diag([2.0, 3.0, 2.5, 1.0]), ("body", "a", "b"), Origin("test"))
    cells = np.diag([1.3, 1.3, 1.3, 1.0])
    cells[:3, 3] = random.uniform(-3, 3, 3)
    names = ("free", "boundary", "part_2", "part_3")
    found = main_labels(labels, names, cells, grid, ("b", "a"))
    for number, name in zip((1, 3, 4), found, strict=True):
        places = np.argwhere(labels == number) * 1.3 + cells[:3, 3]
        nearest = abs(places[:, None] - np.argwhere(voxels >= 0) * [2.0, 3.0, 2.5])
        at = voxels.ravel()[nearest.sum(axis=2).argmin(axis=1)]
        counts = {"a": (at == 2).sum(), "b": (at == 3).sum()}
        assert counts[name] == max(counts.values())
