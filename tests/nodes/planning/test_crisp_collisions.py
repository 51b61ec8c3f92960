"""Solved robots against the anatomy, many at once, and grids that are too coarse."""

from dataclasses import replace

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.crisp_collisions import TOUCHES, check_steps, refuse_coarse_cells
from tests.nodes.planning.made_motions import GOOD, PLACED, bone_map, box_grid, move
from tests.nodes.planning.made_trees import distances, plan_parameters


def codes(motion, *walls, bone=None, **changed):
    grid = box_grid(walls, 4.0)
    cavity = make_cavity(grid, distances(grid))
    names = ("bone",) if bone else ()
    wall = make_wall(bone_map(bone) if bone else bone_map(), names)
    return check_steps(
        PLACED.setup, motion.orientations, motion.lengths_mm, motion.wrenches,
        plan_parameters(**changed), cavity, wall,
    )  # fmt: skip


@pytest.fixture(scope="module")
def motion():
    return move(**GOOD)


def test_in_the_open_nothing_touches(motion):
    assert not codes(motion).any()


def test_an_obstacle_across_the_tool_is_touched_at_every_step(motion):
    wall = (np.array([-9.0, -9, 36]), np.array([9.0, 9, 44]))
    assert [TOUCHES[code] for code in codes(motion, wall)] == ["a needle touches anatomy"] * 6


def test_a_snare_may_touch_the_tool_only_near_its_tip(motion):
    assert [TOUCHES[code] for code in codes(motion, grasp_mm=0.0)] == [
        "needles touch one another"
    ] * 6


def test_bone_behind_an_entry_is_touched_by_the_sheath_and_by_each_its_own(motion):
    """Behind the tool's entry point lies -z, behind the snare's +x."""
    for low, high in (((-3, -3, -20), (3, 3, -14)), ((75, -3, 56), (82, 3, 64))):
        bone = (np.array(low, float), np.array(high, float))
        assert set(codes(motion, bone=bone)) == {3}
        assert not codes(motion, bone=bone, outside_mm=5.0).any()


def test_cells_coarser_than_allowed_are_refused_and_coarse_ones_told():
    fine, coarse = box_grid((), 1.0), box_grid((), 4.0)
    with pytest.raises(BadInput, match="4 mm"):
        refuse_coarse_cells(coarse, PLACED.setup, plan_parameters(coarsest_cell=2.0))
    assert "larger than the radius" in refuse_coarse_cells(
        fine, PLACED.setup, plan_parameters(coarsest_cell=2.0)
    )
    finer = replace(fine, patient_from_index=np.diag([0.5, 0.5, 0.5, 1.0]))
    assert refuse_coarse_cells(finer, PLACED.setup, plan_parameters()) == ""
