"""Set-ups that are handed in are checked, others searched: what comes out can be planned with."""

import numpy as np
import pandas
import pytest

from nodes.errors import BadInput
from nodes.geometry.lines_of_sight import find_surface, sees
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import Goals, PlacedSetups
from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.parameters import SearchCrispSetupsParameters
from nodes.planning.search_crisp_setups import search_crisp_setups
from nodes.planning.setup_candidates import Place, find_candidates
from nodes.planning.setup_judging import Scene, judge_starts
from nodes.planning.setup_scores import find_columns, thin_surface
from nodes.planning.setup_starts import read_entries
from nodes.planning.surface_cells import find_surface_cells
from tests.nodes.planning.made_cavity import ENTRIES, chest, entry_table, occupancy
from tests.nodes.planning.test_check_starts import SOLVING, placed

CHEST = chest()
GRID, DISTANCE = occupancy(CHEST)
NONE = PlacedSetups((), Origin("none"))


def parameters(**changed):
    values = {
        "margin_mm": 0.5, "sheath_mm": 5.0, "outside_mm": 15.0, "grasp_mm": 5.0,
        "sheath_avoids": ("bone",), "piece_mm": 8.0, "coarsest_cell": 9.0, "largest_strain": 1.0,
        "seed": 0, "trees": 1, "node_limit": 60, "time_limit_s": 600.0, "stop_when_seen": False,
        "step_deg": 2.0, "step_mm": 2.0, "lever_mm": 57.0, "seed_from": "parent", "chunk_steps": 8,
        "joints_at_walls": "some", **SOLVING.model_dump(), "material": "nitinol",
        "inner_diameter_mm": 0.84, "outer_diameter_mm": 1.02, "field_of_view_deg": 90.0,
        "joint": "rigid", "grasp_places_mm": (10.0,), "joint_spacing_mm": 10.0,
        "entry_spacing_mm": 15.0, "largest_tilt_deg": 50.0, "shortest_mm": 8.0, "longest_mm": 90.0,
        "directions": 40, "two_needles": 3, "three_needles": 1, "rounds": 2, "setups": 2,
        "for_goals": False, "farthest_start": 32.0, "start_tries": 60,
    }  # fmt: skip
    names = SearchCrispSetupsParameters.model_fields
    values = {name: value for name, value in values.items() if name in names}
    return SearchCrispSetupsParameters(**{**values, **changed})


def goals_at(*cells):
    cells = np.array(cells, int).reshape(-1, 3)
    points = cells @ GRID.patient_from_index[:3, :3].T + GRID.patient_from_index[:3, 3]
    names = tuple(f"goal {n}" for n in range(len(cells)))
    return Goals(names, cells, np.arange(len(cells)), points.astype(float), Origin("test"))


def search(given=NONE, table=None, goals=None, **changed):
    table = entry_table(ENTRIES) if table is None else table
    goals = goals_at() if goals is None else goals
    return search_crisp_setups(given, table, CHEST, GRID, DISTANCE, goals, parameters(**changed))


@pytest.fixture(scope="module")
def found():
    return search()


def test_chosen_set_ups_start_free_and_within_their_limits(found):
    setups, _ = found
    assert [one.name for one in setups.setups] == ["setup 1", "setup 2"]
    cavity, wall = make_cavity(GRID, DISTANCE), make_wall(CHEST, ("bone",))
    scene = Scene(cavity, wall, parameters(), SOLVING)
    rows = entry_table(ENTRIES).set_index("number")
    for one in setups.setups:
        start = one.start
        code = judge_starts(
            one.setup, start.patient_from_entry[None], start.lengths_mm[None], scene
        )
        assert code.tolist() == [0]
        cosine = np.einsum("ni,ni->n", start.patient_from_entry[:, :, 2], one.axes)
        assert (np.arccos(np.clip(cosine, -1, 1)) <= one.largest_tilts_rad + 1e-9).all()
        assert ((start.lengths_mm >= 8) & (start.lengths_mm <= 90)).all()
        for entry, point in zip(one.entries, one.setup.entry_points_patient_mm, strict=True):
            np.testing.assert_allclose(point, rows.loc[entry, "pleura_x_mm":"pleura_z_mm"])
    assert any("limited number of nodes" in notice for notice in setups.origin.notices)


def test_the_table_has_a_row_for_each_candidate_and_halves_them_each_round(found):
    setups, table = found
    assert table["rank"].tolist() == [1, 2, 3, 4] and table.chosen.tolist() == [1, 1, 0, 0]
    assert table.needles.tolist().count(3) == 1
    assert table.share_round_1.notna().all() and table.share_round_2.notna().sum() == 2
    grown = table[table.share_round_2.notna()]
    assert (grown.share_round_2 >= grown.share_round_1).all() and (grown.nodes == 60).all()
    assert (table.nodes[table.share_round_2.isna()] == 30).all()
    assert table.name[:2].tolist() == [one.name for one in setups.setups]
    assert (table.clearance_mm >= 0.5).all()


def test_the_same_input_gives_the_same_set_ups(found):
    setups, table = search()
    pandas.testing.assert_frame_equal(table, found[1])
    for one, same in zip(setups.setups, found[0].setups, strict=True):
        np.testing.assert_array_equal(one.start.patient_from_entry, same.start.patient_from_entry)
        np.testing.assert_array_equal(one.start.lengths_mm, same.start.lengths_mm)


def test_goals_that_an_unbent_start_sees_are_seen_by_the_set_up_that_is_chosen_for_them():
    place = place_of(goals_at())
    candidates = find_candidates(place, parameters(two_needles=50, three_needles=0))
    last = candidates[-1].placed
    entry, tangent = last.setup.entry_points_patient_mm[0], last.start.patient_from_entry[0, :, 2]
    camera = entry + last.start.lengths_mm[0] * tangent
    surface = find_surface(GRID)
    cells = [c for c in find_surface_cells(GRID) if sees(surface, camera, tangent, 30.0, c)]
    goals = goals_at(cells[0])
    _, table = search(goals=goals, for_goals=True, setups=1, two_needles=2, three_needles=0)
    assert table.goals_seen[0] == 1.0


def place_of(goals):
    entries = read_entries(entry_table(ENTRIES), 2)
    cavity, wall = make_cavity(GRID, DISTANCE), make_wall(CHEST, ("bone",))
    return Place(entries, find_surface(GRID), cavity, wall, goals)


def test_second_snares_hold_relaxed_at_right_angles_where_the_first_tool_is():
    candidates = find_candidates(place_of(goals_at()), parameters(two_needles=0))
    assert len(candidates) == 1
    one = candidates[0].placed
    assert [snare.joint for snare in one.setup.snares] == ["rigid", "relaxed"]
    tool = one.setup.entry_points_patient_mm[0]
    way, length = one.start.patient_from_entry[0, :, 2], one.start.lengths_mm[0]
    for snare in one.setup.snares:
        tip = (
            one.setup.entry_points_patient_mm[snare.needle]
            + one.start.lengths_mm[snare.needle] * one.start.patient_from_entry[snare.needle, :, 2]
        )
        np.testing.assert_allclose(tip, tool + (length - snare.grasp_mm) * way, atol=1e-9)
    apart = abs(one.setup.snares[0].grasp_mm - one.setup.snares[1].grasp_mm)
    assert apart >= 10.0


def test_thinned_surfaces_keep_what_is_asked_for_and_goals_count_alike():
    surface = find_surface(GRID)
    goals = goals_at(*find_surface_cells(GRID)[[3, 500, 501]])
    thin = thin_surface(surface, goals.cells, most=100)
    assert 100 <= len(thin.cells) + 1 <= 110
    for cell in goals.cells:
        np.testing.assert_array_equal(thin.cells[thin.numbers[tuple(cell)]], cell)
    columns = find_columns(thin, goals, True)
    assert len(set(np.unique(columns, return_counts=True)[1])) == 1
    assert find_columns(thin, goals, False).tolist() == list(range(len(thin.cells)))


def test_set_ups_that_are_handed_in_are_taken_as_they_are():
    one = placed()
    setups, table = search(PlacedSetups((one,), Origin("by hand")))
    assert setups.setups == (one,) and setups.origin.source == "by hand"
    assert table.name.tolist() == ["mine"] and table.chosen.tolist() == [True]
    assert 0.5 <= table.clearance_mm[0] <= 20


def test_set_ups_that_do_not_work_are_refused_before_anything_is_searched():
    with pytest.raises(BadInput, match="beyond the image"):
        search(PlacedSetups((placed(tool=(29, -8, 30)),), Origin("by hand")))
    with pytest.raises(BadInput, match="nearest start"):
        search(PlacedSetups((placed(snare=(11.5, 37.5, 30)),), Origin("by hand")))


def test_entries_from_which_no_straight_needles_meet_are_refused():
    with pytest.raises(BadInput, match="2 entries, and no two") as error:
        search(table=entry_table(ENTRIES[:2]), largest_tilt_deg=5.0)
    assert "largest_tilt_deg" in error.value.cure
    with pytest.raises(BadInput, match="is empty"):
        search(table=entry_table([]))
    with pytest.raises(BadInput, match=r"cells of 2 mm for a needle of 1\.02 mm"):
        search(coarsest_cell=2.0)
