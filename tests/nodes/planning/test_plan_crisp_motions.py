"""Plans on small trees: found, short, evenly cut, and told why where there is none."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nodes.planning.artefacts import Goals
from nodes.planning.plan_crisp_motions import plan_crisp_motions
from tests.nodes.planning.made_motions import ORIGIN, PLACED, ahead, bone_map, box_grid
from tests.nodes.planning.made_trees import distances, grow, joints, plan_parameters, trees

GRID = box_grid((), 4.0)
DETOUR = [
    joints((15, 0, 0), (0, 5, 0), (5, 5)),
    joints((15, 12, 0), (6, 5, 0), (15, 15)),
    joints((-5, 14, 0), (4, -5, 0), (5, 10)),
]


def goal_at(cells, owners=None):
    owners = np.zeros(len(cells), int) if owners is None else np.array(owners)
    count = int(owners.max()) + 1
    names = tuple(f"place {number}" for number in range(count))
    return Goals(names, np.array(cells, int), owners, np.zeros((count, 3)), ORIGIN)


def cell_ahead(tree, node):
    """The cell in the middle of a node's view."""
    pose = np.eye(4)
    pose[:3, 2], pose[:3, 3] = tree.views[node], tree.cameras_patient_mm[node]

    class Motion:
        patient_from_camera = pose[None]

    return ahead(Motion, GRID)[0]


def plan(tree, goals, **changed):
    parameters = plan_parameters(**changed)
    return plan_crisp_motions(
        trees(tree), GRID, distances(GRID), bone_map(), goals, parameters
    ).plans


@pytest.fixture(scope="module")
def detour():
    narrow = replace(PLACED, setup=replace(PLACED.setup, field_of_view_deg=10.0))
    tree = grow(DETOUR, [0, 1, 2], placed=narrow)
    cell = cell_ahead(tree, 3)
    return replace(tree, seeing=np.array([3])), goal_at([cell])


def test_a_plan_begins_at_the_start_is_shorter_and_cut_evenly(detour):
    found = plan(*detour)[0]
    motion = found.motion
    assert found.status == "planned" and found.cells.tolist() == detour[1].cells.tolist()
    assert np.allclose(motion.orientations[0], PLACED.start.patient_from_entry)
    figures = {figure.name: figure.value for figure in found.figures}
    assert figures["way planned"] < figures["way found"]
    turns = motion.orientations[1:] @ motion.orientations[:-1].swapaxes(-1, -2)
    angles = Rotation.from_matrix(turns.reshape(-1, 3, 3)).magnitude().reshape(-1, 2)
    steps = np.abs(np.diff(motion.lengths_mm, axis=0))
    assert np.degrees(angles).max() <= 1 + 1e-9 and steps.max() <= 1 + 1e-9
    assert angles.max() - angles.max(axis=1).min() < 1e-6  # a straight way in even steps


def test_the_same_input_gives_the_same_motion(detour):
    one, two = (plan(*detour)[0].motion for _ in range(2))
    assert one.wrenches.tobytes() == two.wrenches.tobytes()
    assert one.orientations.tobytes() == two.orientations.tobytes()


def test_what_no_node_sees_is_told_with_what_was_tried(detour):
    tree, goals = detour
    found = plan(replace(tree, seeing=np.array([-1])), goals)[0]
    assert found.status == "not seen" and "4 configurations" in found.reason
    assert not len(found.motion.lengths_mm)


def test_a_node_that_cannot_be_reached_within_the_limits_is_no_plan(detour):
    tree, goals = detour
    narrow = replace(PLACED, largest_tilts_rad=np.radians([5.0, 5.0]))
    found = plan(replace(tree, placed=narrow), goals)[0]
    assert found.status == "not seen" and "stays valid" in found.reason


def test_a_region_is_seen_from_as_few_nodes_as_see_all_of_it(detour):
    tree, _ = detour
    cells = [cell_ahead(tree, 0), cell_ahead(tree, 3)]
    both = plan(replace(tree, seeing=np.array([0, 3])), goal_at(cells, [0, 0]))
    assert [found.goal for found in both] == ["place 0 1/2", "place 0 2/2"]
    seen = {tuple(cell) for found in both for cell in found.cells.tolist()}
    assert seen == {tuple(cell.tolist()) for cell in cells}
    one = plan(replace(tree, seeing=np.array([0, 3])), goal_at(cells, [0, 0]), viewpoints=1)
    assert len(one) == 1 and one[0].goal == "place 0"


def test_without_trees_there_are_no_plans_and_it_is_said(detour):
    nothing = plan_crisp_motions(
        trees(), GRID, distances(GRID), bone_map(), detour[1], plan_parameters()
    )
    assert nothing.plans == () and any("no set-up" in said for said in nothing.origin.notices)
