"""Dice against sets, and comparable meanings of "body"."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.imaging.score_segmentation import score_segmentation

GRID = np.diag([10.0, 10.0, 10.0, 1.0])
labels = arrays(np.uint8, (3, 3, 2), elements=st.integers(0, 3))


def label_map(voxels, names, grid=GRID):
    return LabelMap(np.asarray(voxels, np.uint8), grid, names, Origin("test"))


@settings(max_examples=50, deadline=None)
@given(labels, labels)
def test_dice_is_that_of_the_sets_and_body_takes_what_the_other_does_not_know(found, true):
    table = score_segmentation(
        label_map(found, ("body", "bone", "nodule")), label_map(true, ("bone", "effusion", "body"))
    ).set_index("label")
    assert list(table.index) == ["body", "bone"]
    places = [tuple(place) for place in np.ndindex(found.shape)]
    sets = {
        "bone": ({p for p in places if found[p] == 2}, {p for p in places if true[p] == 1}),
        "body": (
            {p for p in places if found[p] in (1, 3)},
            {p for p in places if true[p] in (2, 3)},
        ),
    }
    for name, (one, other) in sets.items():
        total = len(one) + len(other)
        assert table.dice[name] == pytest.approx(2 * len(one & other) / total if total else 1)
        assert table.volume_ml[name] == pytest.approx(len(one))
        assert table.truth_volume_ml[name] == pytest.approx(len(other))


def test_other_grids_and_strange_names_are_refused():
    one = label_map(np.ones((2, 2, 2)), ("bone",))
    with pytest.raises(BadInput, match="grids"):
        score_segmentation(one, label_map(np.ones((2, 2, 3)), ("bone",)))
    with pytest.raises(BadInput, match="grids"):
        score_segmentation(one, label_map(np.ones((2, 2, 2)), ("bone",), np.diag([9.0, 10, 10, 1])))
    with pytest.raises(BadInput, match="in common"):
        score_segmentation(one, label_map(np.ones((2, 2, 2)), ("lungs",)))
