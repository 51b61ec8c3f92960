"""Trees come back bit by bit, and are drawn as their edges."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.crisp_trees import CrispTreesFormat
from catalog.formats.plain_values import COMPUTED
from catalog.formats.vtp_arrays import read_points
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import CrispTrees
from tests.catalog.formats.hostile import ORIGINS
from tests.catalog.formats.made_plan_files import assert_equal, trees


@settings(max_examples=25, deadline=None)
@given(st.lists(trees(), max_size=2).map(tuple), ORIGINS)
def test_everything_comes_back(grown, origin) -> None:
    value = CrispTrees(grown, origin)
    assert_equal(CrispTreesFormat.decode(CrispTreesFormat.encode(value)), value)


@settings(max_examples=10, deadline=None)
@given(trees())
def test_points_are_cameras_and_files_say_that_they_are_computed(tree) -> None:
    content = CrispTreesFormat.encode(CrispTrees((tree,), Origin("a test")))["tree_1.vtp"]
    np.testing.assert_array_equal(read_points(content).points, tree.cameras_patient_mm)
    assert COMPUTED.encode() in content
    assert f'NumberOfLines="{len(tree.parents) - 1}"'.encode() in content
