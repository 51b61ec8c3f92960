"""A person's labels win, and only where they fit the image."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given as for_all
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin
from nodes.imaging.hand_labels import check_given_labels, replace_labels

SHAPE = (4, 3, 5)
GRID = np.array([[0, -2.0, 0, 1], [3, 0, 0, 2], [0, 0, 5, 3], [0, 0, 0, 1]])
VOLUME = Volume(np.zeros(SHAPE, np.int16), GRID, "HU", Origin("test"))
NOTHING = LabelMap(np.zeros((1, 1, 1), np.uint8), np.eye(4), (), Origin("nothing"))
DRAWN = LabelMap(np.ones(SHAPE, np.uint8), GRID, ("body",), Origin("drawn"))


def labels(names):
    """Maps with any labels of these names."""
    voxels = arrays.arrays(np.uint8, SHAPE, elements=st.integers(0, len(names)))
    return voxels.map(lambda values: LabelMap(values, GRID, names, Origin("test")))


@for_all(labels(("body", "bone", "lung")), labels(("bone", "needle")))
def test_each_voxel_follows_the_persons_word_first(found, drawn):
    result = replace_labels(found, drawn)
    assert result.names == ("body", "bone", "lung", "needle")
    for place in np.ndindex(SHAPE):
        was, word = found.voxels[place], drawn.voxels[place]
        undrawn = {0: 0, 1: 1, 2: 1, 3: 3}[was]  # bone that was not drawn is body
        assert result.voxels[place] == {0: undrawn, 1: 2, 2: 4}[word]


@for_all(labels(("body", "bone")))
def test_body_ends_where_the_person_drew_its_end(found):
    drawn = replace(DRAWN, voxels=(np.indices(SHAPE)[0] < 2).astype(np.uint8))
    result = replace_labels(found, drawn)
    assert (result.voxels[:2] == 1).all()
    np.testing.assert_array_equal(result.voxels[2:], np.where(found.voxels[2:] == 2, 2, 0))


@for_all(labels(("body", "bone")))
def test_nothing_given_changes_nothing(found):
    check_given_labels(VOLUME, NOTHING)
    assert replace_labels(found, NOTHING) is found


def test_origin_tells_what_was_drawn_and_what_is_simulated():
    drawn = replace(DRAWN, origin=Origin("x", simulated=True, notices=("freehand",)))
    origin = replace_labels(replace(DRAWN, names=("head",)), drawn).origin
    assert origin.simulated and "freehand" in origin.notices
    assert any("by hand" in notice and "body" in notice for notice in origin.notices)


def test_the_grid_may_differ_by_the_rounding_of_a_file():
    check_given_labels(VOLUME, replace(DRAWN, patient_from_index=GRID + 1e-4))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"voxels": np.ones((4, 3, 6), np.uint8)}, "4 x 3 x 6"),
        ({"patient_from_index": GRID @ np.diag([1, 1, 1.01, 1])}, "grid"),
        ({"patient_from_index": np.linalg.inv(GRID)}, "grid"),
        ({"names": ("body", "body")}, "a name of its own"),
        ({"voxels": np.full(SHAPE, 2, np.uint8)}, "label value 2"),
    ],
)
def test_labels_that_cannot_be_laid_over_the_image_are_refused(change, words):
    with pytest.raises(BadInput, match=words):
        check_given_labels(VOLUME, replace(DRAWN, **change))


def test_more_labels_than_numbers_are_refused():
    many = replace(DRAWN, names=tuple(f"label {n}" for n in range(255)))
    with pytest.raises(BadInput, match="256 labels"):
        replace_labels(DRAWN, many)
