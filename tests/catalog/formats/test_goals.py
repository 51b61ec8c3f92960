"""Goals come back, and 3D Slicer is shown the same points."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.goals import GoalsFormat
from catalog.formats.sites import SitesFormat
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import Goals
from tests.catalog.formats.hostile import NAMES, ORIGINS
from tests.catalog.formats.made_plan_files import array, assert_equal, whole


@settings(max_examples=50, deadline=None)
@given(st.lists(NAMES, max_size=3), st.integers(0, 4), ORIGINS, st.data())
def test_everything_comes_back(names, cells, origin, data) -> None:
    value = Goals(
        tuple(names), data.draw(whole(cells, 3)), data.draw(whole(cells)),
        data.draw(array(len(names), 3)), origin,
    )  # fmt: skip
    assert_equal(GoalsFormat.decode(GoalsFormat.encode(value)), value)


def test_slicer_is_shown_the_same_points() -> None:
    points = np.array([[1.0, 2, 3], [4, 5, 1 / 3]])
    goals = Goals(("a", "b"), np.array([[1, 2, 3], [4, 5, 6]]), np.array([0, 1]), points,
                  Origin("a test"))  # fmt: skip
    shown = SitesFormat.decode({"g.mrk.json": GoalsFormat.encode(goals)["goals.mrk.json"]})
    assert shown.point_names == ("a", "b")
    np.testing.assert_array_equal(shown.points_patient_mm, points)
