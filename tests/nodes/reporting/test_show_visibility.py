from base64 import b64decode

import numpy as np
import pytest

from nodes.reporting.show_visibility import blend, make_paints, show_visibility
from tests.nodes.reporting import made_plans
from tests.nodes.reporting.test_show_sites import points_of, scene_of


@pytest.fixture(scope="module")
def show_sets(defaults):
    """Give `show_sets(*names)`: the section of set-ups with these names."""

    def show_sets(*names, **changes):
        sets = made_plans.make_sets(*names)
        return show_visibility(
            sets,
            made_plans.make_trees(*names),
            made_plans.make_distance(),
            made_plans.make_table(sets),
            defaults("show_visibility", cell_mm=3.0, curve_points=20, **changes),
        )

    return show_sets


@pytest.fixture(scope="module")
def section(show_sets):
    return show_sets("one", "two")


def cavity_of(section):
    scene = scene_of(section)
    return scene, next(item for item in scene["objects"] if item["name"] == "cavity")


def kinds_of(scene, paint):
    return np.frombuffer(b64decode(scene["buffers"][paint["kinds"]["buffer"]]), np.uint8)


def test_the_surface_is_painted_where_the_set_up_sees_it(section):
    """Set-up "one" sees what is right of 0, "two" what is right of -10 mm."""
    scene, cavity = cavity_of(section)
    x = points_of(scene, "cavity")[:, 0]
    together = kinds_of(scene, cavity["paints"][0])
    expected = np.where(x > 0, 3, np.where(x > -10, 2, 0))
    sure = (np.abs(x) > 3) & (np.abs(x + 10) > 3)
    assert (together[sure] == expected[sure]).all()


def test_the_shares_in_the_key_are_those_of_the_cells(section):
    _, cavity = cavity_of(section)
    cells = made_plans.make_cells()
    x = cells[:, 0] * 2.0 + made_plans.PATIENT_FROM_INDEX[0, 3]
    seen = next(paint for paint in cavity["paints"] if paint["name"] == "seen by one")
    assert seen["meanings"][1] == f"seen ({100 * (x > 0).mean():.1f} %)"
    shares = [float(text.split("(")[1].split()[0]) for text in cavity["paints"][0]["meanings"]]
    assert sum(shares) == pytest.approx(100, abs=0.2)


def test_what_is_seen_later_has_a_later_colour(section):
    scene, cavity = cavity_of(section)
    x = points_of(scene, "cavity")[:, 0]
    paint = next(one for one in cavity["paints"] if one["name"] == "first seen by one")
    kinds = kinds_of(scene, paint)
    right = x > 4
    assert np.corrcoef(-x[right], kinds[right])[0, 1] > 0.95
    assert not kinds[x < -4].any()
    assert len(paint["colours"]) == len(paint["meanings"])


def test_there_is_a_paint_of_who_and_when_for_each_set_up_and_all(section):
    _, cavity = cavity_of(section)
    assert [paint["name"] for paint in cavity["paints"]] == [
        "seen by all together", "seen by one", "seen by two",
        "first seen by any set-up", "first seen by one", "first seen by two",
    ]  # fmt: skip


def test_three_set_ups_are_counted(show_sets):
    _, cavity = cavity_of(show_sets("one", "two", "three"))
    assert [text.split(" (")[0] for text in cavity["paints"][0]["meanings"]] == [
        "not seen", "by 1 of 3", "by 2 of 3", "by 3 of 3",
    ]  # fmt: skip


def test_one_set_up_has_no_union(show_sets):
    section = show_sets("one")
    _, cavity = cavity_of(section)
    assert [paint["name"] for paint in cavity["paints"]] == ["seen by one", "first seen by one"]
    assert "union" not in section.html


def test_curves_and_table_stand_below_the_view(section):
    assert section.html.index("viewer3d") < section.html.index("Share of the whole surface")
    assert ">share seen <" in section.html and "48.5" in section.html


def test_nothing_seen_is_shown_as_such():
    sets = made_plans.make_sets("one")
    first = np.full_like(sets.sets[0].first_nodes, -1)
    blind = made_plans.VisibilitySet("one", first, sets.sets[0].seconds)
    none = made_plans.replace(sets, sets=(blind,))
    seen, times = make_paints(none, np.array([[0.0, 0, 24], [40, 0, 0]]), 6, 7)
    assert seen.meanings == ("not seen (100.0 %)", "seen (0.0 %)")
    assert not seen.kinds.any() and not times.kinds.any()


def test_later_colours_are_darker():
    light = [sum(int(colour[at : at + 2], 16) for at in (1, 3, 5)) for colour in blend(6)]
    assert light == sorted(light, reverse=True) and len(set(light)) == 6


def test_what_is_left_out_is_nowhere_and_counts_for_no_union(show_sets):
    section = show_sets("one, from parent", "one, from zero", left_out=("from zero",))
    scene, cavity = cavity_of(section)
    assert [choice["name"] for choice in scene["choices"]] == ["one, from parent"]
    assert [paint["name"].split(" by ")[1] for paint in cavity["paints"]] == [
        "one, from parent"
    ] * 2
    assert "zero" not in section.html and "union" not in section.html
