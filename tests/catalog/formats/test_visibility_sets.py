"""Visibility sets come back, and label maps show in the same cells what is seen."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.labelmap import LabelMapFormat
from catalog.formats.visibility_sets import VisibilitySetsFormat
from catalog.formats.vtp_arrays import read_points
from nodes.geometry.origin import Origin
from nodes.visibility.artefacts import VisibilitySet, VisibilitySets
from tests.catalog.formats.hostile import NAMES, ORIGINS, affines
from tests.catalog.formats.made_plan_files import array, assert_equal


@settings(max_examples=30, deadline=None)
@given(affines(), st.lists(NAMES, max_size=2), ORIGINS, st.data())
def test_everything_comes_back(affine, names, origin, data) -> None:
    cells = np.array([[0, 0, 0], [1, 2, 3], [2, 0, 1]])[: data.draw(st.integers(0, 3))]
    sets = []
    for name in names:
        nodes = data.draw(st.integers(1, 4))
        first = data.draw(st.lists(st.integers(-1, nodes - 1), min_size=3, max_size=3))
        sets.append(
            VisibilitySet(name, np.array(first[: len(cells)], int), data.draw(array(nodes)))
        )
    value = VisibilitySets(cells, affine, (3, 3, 4), "first hit", tuple(sets), origin)
    assert_equal(VisibilitySetsFormat.decode(VisibilitySetsFormat.encode(value)), value)


def test_label_maps_and_points_show_what_is_seen_where_and_when() -> None:
    cells = np.array([[0, 0, 0], [1, 2, 3], [2, 0, 1]])
    affine = np.diag([2.0, 2, 2, 1])
    one = VisibilitySet("a", np.array([-1, 1, 0]), np.array([0.5, 1.5]))
    two = VisibilitySet("b", np.array([0, -1, -1]), np.array([9.0]))
    value = VisibilitySets(cells, affine, (3, 3, 4), "own ray", (one, two), Origin("a test"))
    files = VisibilitySetsFormat.encode(value)

    def shown(name: str) -> tuple[list, list]:
        labels = LabelMapFormat.decode({"labels.seg.nrrd": files[name]})
        return tuple(np.argwhere(labels.mask(each)).tolist() for each in ("seen", "not seen"))

    assert shown("seen_1.seg.nrrd") == ([[1, 2, 3], [2, 0, 1]], [[0, 0, 0]])
    assert shown("seen_2.seg.nrrd") == ([[0, 0, 0]], [[1, 2, 3], [2, 0, 1]])
    assert shown("seen_by_any.seg.nrrd") == ([[0, 0, 0], [1, 2, 3], [2, 0, 1]], [])
    table = read_points(files["cells.vtp"])
    np.testing.assert_array_equal(table.points, 2 * cells)
    assert table.columns["first_second_1"].tolist() == [-1, 1.5, 0.5]
