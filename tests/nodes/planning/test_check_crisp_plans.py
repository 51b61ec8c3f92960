"""A good motion passes; each kind of bad one is refused, and says where and by what rule."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Material, Needle, Snare
from nodes.mechanics.solve_crisp import find_crisp_equilibria
from nodes.planning.artefacts import (
    CheckedPlan,
    CrispMotion,
    Goals,
    MotionPlan,
    MotionPlans,
    PlacedSetup,
)
from nodes.planning.check_crisp_plans import check_crisp_plans
from tests.nodes.planning.made_motions import (
    GOOD,
    NEEDLE,
    ORIGIN,
    PARAMETERS,
    PLACED,
    SETUP,
    START,
    ahead,
    around,
    bone_map,
    box_grid,
    move,
    plan,
    solve_motion,
)

BONE = bone_map(((-40, -60, -60), (-20, 60, 0)))
GRID = box_grid()


def goals_of(made: MotionPlan) -> Goals:
    """Return the goals that a motion is made for."""
    point = made.goal_point_patient_mm[None]
    return Goals((made.goal,), made.cells, np.zeros(len(made.cells), int), point, ORIGIN)


def check(made: MotionPlan, grid=GRID, bone=BONE, goals=None, **changed) -> CheckedPlan:
    parameters = PARAMETERS.model_copy(update=changed)
    plans = MotionPlans((made,), ORIGIN)
    checked, table = check_crisp_plans(plans, goals or goals_of(made), grid, bone, parameters)
    (verdict,) = checked.plans
    assert verdict.passed == (not verdict.failures)
    assert (table["verdict"][0] == "plan") == verdict.passed
    return verdict


def refused(made: MotionPlan, *told: str, **changed) -> CheckedPlan:
    verdict = check(made, **changed)
    assert len(verdict.failures) == 1, verdict.failures
    for words in told:
        assert words in verdict.failures[0]
    return verdict


def figure(verdict: CheckedPlan, name: str) -> float:
    return next(each.value for each in verdict.figures if each.name == name)


@pytest.fixture(scope="module")
def motion() -> CrispMotion:
    return move(**GOOD)


@pytest.fixture(scope="module")
def good(motion) -> MotionPlan:
    return plan(motion, ahead(motion, GRID))


@pytest.fixture(scope="module")
def passed(good) -> CheckedPlan:
    return check(good)


def test_a_good_motion_passes_with_its_numbers(passed, motion) -> None:
    assert passed.passed
    assert passed.clearances_mm.min() == figure(passed, "least clearance")
    assert passed.margins.min() == figure(passed, "smallest stability margin")
    assert len(passed.margins) == len(passed.clearances_mm) == 6
    forces = np.linalg.norm(motion.wrenches[:, :, 3:], axis=2).max(axis=0)
    told = [figure(passed, f"largest force at the entry of the {n}") for n in ("tool", "snare 1")]
    assert told == pytest.approx(forces, rel=1e-3)
    turns = Rotation.from_rotvec(np.radians([GOOD["tool"], GOOD["snare"]])).magnitude()
    assert figure(passed, "largest turn of a step") == pytest.approx(np.degrees(turns.max()) / 5)
    assert figure(passed, "largest shift of a step") == pytest.approx(3 / 5)
    assert figure(passed, "cells of the goal seen") == 1


def test_the_same_motion_has_the_same_verdict(passed, good) -> None:
    again = check(good)
    assert again.figures == passed.figures
    assert again.clearances_mm.tobytes() == passed.clearances_mm.tobytes()


def swing(degrees: float) -> CrispMotion:
    """In one step, the tool to the side, and the snare along with it."""
    return move(tool=(-degrees, 0, 0), snare=(0, 0, -degrees), steps=2)


def test_a_wall_that_the_tip_tunnels_through_between_two_steps_is_found() -> None:
    swung = swing(9)
    tips = swung.patient_from_camera[:, :3, 3]
    assert np.linalg.norm(tips[1] - tips[0]) > 7
    middle = np.round(tips.mean(axis=0))
    thin = around(middle, (-5, -0.1, -8), (5, 1, 4))
    grid = box_grid([thin], cell=1.0)
    made = plan(swung, ahead(swung, grid))
    refused(made, "between steps 0 and 1 the tool touches anatomy", grid=grid,
            largest_step_deg=10.0)  # fmt: skip
    slow = check(made, grid=grid)
    assert any("turns by 9 degrees; at most 2 are allowed" in each for each in slow.failures)


def test_a_corner_that_is_grazed_between_two_steps_is_found() -> None:
    """Ten times finer, the way between two steps that are free is found to touch."""
    swung = swing(5)
    tips = swung.patient_from_camera[:, :3, 3]
    corner = around(np.round(tips.mean(axis=0)), (1.0, -0.6, -4), (9, 0.6, 4))
    grid = box_grid([corner], cell=1.0)
    made = plan(swung, ahead(swung, grid))
    loose = {"largest_step_deg": 10.0, "margin_mm": 0.6, "clear_mm": 0.8}
    for step in range(2):
        still = CrispMotion(*(v[[step]] for v in vars(swung).values()))
        start = CrispConfiguration(swung.orientations[step], swung.lengths_mm[step])
        alone = plan(still, ahead(still, grid), replace(PLACED, start=start))
        assert check(alone, grid=grid, **loose).passed
    refused(made, "between steps 0 and 1 the tool may come within", grid=grid, **loose)


def test_a_motion_that_begins_elsewhere_is_refused(motion, good) -> None:
    later = CrispMotion(*(v[1:] for v in vars(motion).values()))
    verdict = check(plan(later, good.cells))
    assert all("step 0 is not the start of the robot" in each for each in verdict.failures)
    assert len(verdict.failures) == 2


@pytest.mark.parametrize("sought", ["behind", "beside", "hidden"])
def test_a_goal_that_the_camera_does_not_see_is_refused(motion, good, sought) -> None:
    cells, grid = np.array(good.cells), GRID
    if sought == "behind":
        cells[0, 2] = 1
    if sought == "beside":
        cells[0, 0] += 45 if cells[0, 0] < 25 else -45
        cells[0] = np.clip(cells[0], 1, np.array(GRID.voxels.shape) - 2)
    if sought == "hidden":
        tip = motion.patient_from_camera[-1, :3, 3]
        grid = box_grid([around(tip, (-9, -9, 14), (9, 9, 18))])
    refused(plan(motion, cells), "sees 0 of the 1 cells", grid=grid)


def test_a_cell_that_is_not_on_the_surface_is_no_goal(motion, good) -> None:
    inside = good.cells - [0, 0, 3]
    refused(plan(motion, inside), "not on the surface")


@pytest.mark.parametrize(
    ("limits", "told"),
    [
        ({"longest_mm": np.array([72.0, 120])}, "the tool is 73 mm long; between 30 and 72 mm"),
        ({"shortest_mm": np.array([30.0, 60.5])}, "at step 0 the snare 1 is 60 mm long"),
        ({"largest_tilts_rad": np.radians([4.0, 40])}, "at step 5 the tool tilts by 5 degrees"),
    ],
)
def test_limits_of_the_setup_are_kept(good, limits, told) -> None:
    refused(replace(good, placed=replace(PLACED, **limits)), told)


def test_a_sheath_that_tilts_into_bone_is_refused(good) -> None:
    bone = bone_map(((1, -60, -60), (20, 60, -25)))
    straight = plan(move(longer=(2, 0)), good.cells)
    beside = check(straight, bone=bone)
    assert not any("sheath of" in each for each in beside.failures), beside.failures
    tilted = move(tool=(0, -3, 0), snare=(0, 0, 0))
    verdict = check(plan(tilted, ahead(tilted, GRID)), bone=bone)
    assert len(verdict.failures) == 1
    assert "the sheath of the tool may come within" in verdict.failures[0]
    assert "mm of bone" in verdict.failures[0]


def test_claims_that_are_not_what_the_robot_does_are_refused(motion, good) -> None:
    poses, wrenches = np.array(motion.patient_from_camera), np.array(motion.wrenches)
    poses[3, 0, 3] += 0.05
    wrenches[4, 1, 3] += 0.01
    refused(replace(good, motion=replace(motion, patient_from_camera=poses)), "step 3 is not what")
    refused(replace(good, motion=replace(motion, wrenches=wrenches)), "step 4 is not what")


def test_a_jump_to_another_branch_is_refused() -> None:
    """A long snare bends to either side; a motion that changes sides says so by its wrenches."""
    lengths = START.lengths_mm + np.array([0, 12.0])
    found = [
        each
        for each in find_crisp_equilibria(
            SETUP, CrispConfiguration(START.patient_from_entry, lengths), PARAMETERS
        )
        if each.status == "solved"
    ]
    assert len(found) > 1
    one, other = found[0], found[1]
    made = CrispMotion(
        np.repeat(START.patient_from_entry[None], 2, 0), np.repeat(lengths[None], 2, 0),
        np.array([one.base_wrenches, other.base_wrenches]),
        np.array([one.patient_from_camera, other.patient_from_camera]),
    )  # fmt: skip
    start = CrispConfiguration(START.patient_from_entry, lengths)
    placed = replace(PLACED, start=start)
    verdict = check(plan(made, ahead(made, GRID), placed))
    assert any("step 1 is not what the robot does" in each for each in verdict.failures)
    backwards = replace(made, wrenches=made.wrenches[::-1],
                        patient_from_camera=made.patient_from_camera[::-1])  # fmt: skip
    if other.energy_n_mm > one.energy_n_mm * (1 + 1e-6):
        verdict = check(plan(backwards, ahead(made, GRID), placed))
        assert any("at step 0 the robot rests in another shape" in e for e in verdict.failures)


def test_a_motion_beyond_where_the_robot_has_a_shape_is_refused(motion, good) -> None:
    """The snare is drawn back until it is taut, which no shape allows."""
    lengths = np.array(motion.lengths_mm)
    lengths[:, 1] = 60 - np.arange(6) * 10
    verdict = check(replace(good, motion=replace(motion, lengths_mm=lengths)))
    assert any("the robot finds no stable shape" in each for each in verdict.failures)
    assert any("does not get to the last step" in each for each in verdict.failures)
    assert np.isnan(verdict.margins[-1]) and np.isfinite(verdict.margins[0])


def test_needles_that_pass_through_each_other_are_refused() -> None:
    """Two straight snares cross on their ways to the tool."""
    slope = -20 / np.hypot(60, 20)
    joints = [Snare(1, 30.0, "tip", "relaxed", slope), Snare(2, 10.0, "tip", "relaxed", -slope)]
    entries = np.array([[0.0, 0, 0], [60, 0, 80], [60, 0, 60]])
    setup = CrispSetup((NEEDLE,) * 3, entries, tuple(joints), 80.0)
    ways = np.array([[0.0, 0, 1], [-60, 0, -20], [-60, 0, 20]])
    frames = np.array([Rotation.align_vectors([way], [[0, 0, 1]])[0].as_matrix() for way in ways])
    lengths = np.array([90, *np.linalg.norm(ways[1:], axis=1)])
    motion = solve_motion(np.repeat(frames[None], 2, 0), np.repeat(lengths[None], 2, 0), setup)
    placed = PlacedSetup("crossed", setup, CrispConfiguration(frames, lengths), frames[:, :, 2],
                         np.ones(3), lengths / 2, lengths * 2)  # fmt: skip
    made = plan(motion, ahead(motion, GRID), placed)
    refused(made, "the snare 1 and the snare 2 touch or pass through each other")


def test_a_needle_strained_beyond_what_it_comes_back_from_is_refused(good) -> None:
    brittle = Material("glass", 50000.0, 0.33, 0.0005)
    needles = (Needle(brittle, 0.84, 1.02, np.zeros(3)), NEEDLE)
    setup = replace(SETUP, needles=needles)
    refused(replace(good, placed=replace(PLACED, setup=setup)), "the tool is strained by", "glass")


def test_a_robot_near_snapping_is_refused(good) -> None:
    refused(good, "the stability margin is", "at least 0.99", least_margin=0.99)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda m: {"lengths_mm": np.full_like(m.lengths_mm, np.nan)}, "no finite number"),
        (
            lambda m: {"orientations": 1.01 * m.orientations},
            "step 0: an orientation is no rotation",
        ),
        (lambda m: {"orientations": -m.orientations}, "step 0: an orientation is no rotation"),
        (lambda m: {"lengths_mm": m.lengths_mm - [65, 0]}, "not inside as far as it is grasped"),
    ],
)
def test_nonsense_is_refused_without_being_solved(good, change, told) -> None:
    verdict = refused(replace(good, motion=replace(good.motion, **change(good.motion))), told)
    assert not verdict.figures and np.isnan(verdict.margins).all()


def test_what_has_no_motion_is_no_plan(good) -> None:
    nothing = CrispMotion(*(v[:0] for v in vars(good.motion).values()))
    none = replace(good, motion=nothing, status="unreachable", reason="too far away")
    refused(none, "there is no motion to check: too far away")
    refused(replace(none, status="planned"), "the motion has no steps")


def test_a_step_that_moves_nothing_passes(good) -> None:
    still = move(steps=1)
    assert check(plan(still, ahead(still, GRID))).passed


@pytest.mark.parametrize("thickness", [8, 14])
def test_a_wall_thicker_than_the_sheath_is_refused(good, thickness) -> None:
    thick = box_grid([((-40, -30, 0), (60, 30, thickness))])
    made = plan(good.motion, ahead(good.motion, thick))
    if thickness < PARAMETERS.sheath_mm:
        part = figure(check(made, grid=thick), "longest part in a sheath")
        assert thickness < part <= PARAMETERS.sheath_mm
    else:
        refused(made, "the tool touches anatomy", grid=thick)


def test_a_motion_to_another_goal_than_it_names_is_refused(good) -> None:
    asked = goals_of(good)
    assert check(replace(good, goal=f"{good.goal} 2/3"), goals=asked).passed
    for changed, told in (
        ({"goal": "another"}, "none of the goals"),
        ({"goal_point_patient_mm": good.goal_point_patient_mm + 1}, "another point"),
        ({"status": "not seen"}, "the planner calls it not seen"),
        ({"cells": np.repeat(good.cells, 2, axis=0)}, "more than once"),
    ):
        verdict = check(replace(good, **changed), goals=asked)
        assert any(told in failure for failure in verdict.failures)
    elsewhere = replace(asked, cells=asked.cells + 1)
    assert any("are not" in failure for failure in check(good, goals=elsewhere).failures)
