import numpy as np
import pytest

from nodes.reporting.first_view import choose_first_slices


@pytest.fixture
def chest():
    """A body with a lung along all of k and a nodule in a corner of it."""
    labels = np.zeros((30, 20, 40), np.uint8)
    labels[2:28, 2:18] = 1
    labels[4:12, 4:16, 2:38] = 2
    labels[6:9, 5:8, 30:33] = 3
    return labels


def test_a_nodule_counts_as_much_as_a_lung(chest):
    assert choose_first_slices(chest, (2, 3)) == [7, 6, 31]


def test_what_is_not_shown_does_not_count(chest):
    i, j, k = choose_first_slices(chest, (2,))
    assert 4 <= i < 12 and 4 <= j < 16 and 2 <= k < 38
    assert not (chest[:, :, k] == 3).any()  # where the nodule takes from the lung


def test_every_label_counts_where_none_is_shown(chest):
    assert choose_first_slices(chest, ()) == [7, 6, 31]


def test_the_middle_is_shown_where_nothing_is_labelled():
    assert choose_first_slices(np.zeros((9, 6, 4), np.uint8), (1,)) == [4, 3, 2]


def test_each_first_slice_shows_no_less_than_any_other():
    labels = np.random.default_rng(3).integers(0, 5, (7, 8, 9)).astype(np.uint8)

    def earned(axis, place):
        def area(label, n):
            return (labels.take(n, axis) == label).sum()

        return sum(
            area(label, place) / max(area(label, n) for n in range(labels.shape[axis]))
            for label in (1, 2, 4)
        )

    for axis, place in enumerate(choose_first_slices(labels, (1, 2, 4))):
        assert all(earned(axis, place) >= earned(axis, n) - 1e-9 for n in range(labels.shape[axis]))
