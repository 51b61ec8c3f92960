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


def test_lungs_are_scored_together_and_a_lung_that_one_map_lacks_is_no_body():
    found = np.array([1, 1, 2, 2, 3, 0, 0, 0]).reshape(2, 2, 2)
    true = np.array([1, 0, 2, 2, 2, 2, 0, 0]).reshape(2, 2, 2)
    table = score_segmentation(
        label_map(found, ("body", "left_lung", "right_lung")), label_map(true, ("body", "lungs"))
    ).set_index("label")
    assert list(table.index) == ["body", "lungs"]
    assert table.dice["lungs"] == pytest.approx(2 * 3 / (3 + 4))
    assert table.dice["body"] == pytest.approx(2 * 1 / (2 + 1))
    assert table.volume_error_percent["lungs"] == pytest.approx(-25)


def test_surfaces_of_two_slabs_are_as_far_apart_as_the_slabs():
    one, other = np.zeros((12, 4, 4)), np.zeros((12, 4, 4))
    one[2:6], other[2:9] = 1, 1  # in the middle, the far faces are 3 voxels of 10 mm apart
    row = score_segmentation(label_map(one, ("bone",)), label_map(other, ("bone",))).iloc[0]
    assert row.surface_95_mm == pytest.approx(30)
    assert 0 < row.mean_surface_mm < 30


def test_an_empty_label_has_no_surface_and_no_error_in_percent():
    nothing, some = np.zeros((3, 3, 3)), np.ones((3, 3, 3))
    row = score_segmentation(label_map(some, ("bone",)), label_map(nothing, ("bone",))).iloc[0]
    assert row.dice == 0
    assert np.isnan([row.volume_error_percent, row.mean_surface_mm, row.surface_95_mm]).all()
