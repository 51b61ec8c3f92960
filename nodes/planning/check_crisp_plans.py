"""Whether motions may be called plans, by a check that shares no code with planners."""

from typing import TYPE_CHECKING

import numpy as np

from nodes.geometry.grids import LabelMap
from nodes.mechanics.shapes import Figure
from nodes.planning.artefacts import CheckedPlan, CheckedPlans, Goals, MotionPlan, MotionPlans
from nodes.planning.checking_boxes import Boxes, make_boxes
from nodes.planning.checking_goals import check_goal
from nodes.planning.checking_mechanics import check_mechanics
from nodes.planning.checking_shapes import Followed, follow_motion
from nodes.planning.checking_sight import are_on_surface, see_cells
from nodes.planning.checking_steps import (
    check_joint_steps,
    check_limits,
    check_start,
    cut_finely,
    find_nonsense,
    least_at_steps,
)
from nodes.planning.checking_touches import Space, check_touches
from nodes.planning.parameters import CheckCrispPlansParameters

if TYPE_CHECKING:
    import pandas

CHECKED = (
    "verdicts hold for the model: straight needles without loads, joints without play, anatomy that"
    " does not move"
)


def check_crisp_plans(
    motion_plans: MotionPlans,
    goals: Goals,
    occupancy_grid: LabelMap,
    label_map: LabelMap,
    parameters: CheckCrispPlansParameters,
) -> tuple[CheckedPlans, "pandas.DataFrame"]:
    """Return the verdict on each motion, and a table of them.

    Each motion is cut anew, and every configuration solved by the general mechanics from the one
    before it. Clearances are lower bounds: what needles bend between samples and move between
    configurations is taken off.

    Parameters
    ----------
    motion_plans : as a planner found them.
    goals : that were asked for.
    occupancy_grid : all but "free" is anatomy, and so is what lies beyond the grid.
    label_map : what sheaths avoid outside.

    Returns
    -------
    checked_plans : what breaks any rule has not passed, and says each rule that it breaks.
    plan_table : one row a plan.

    Raises
    ------
    BadInput where `sheath_avoids` names a label that is not there, or a grid is oblique.
    """
    cavity = make_boxes(~occupancy_grid.mask("free"), occupancy_grid.patient_from_index, True)
    space = Space(cavity, label_map)
    checked = tuple(_check(plan, goals, space, parameters) for plan in motion_plans.plans)
    origin = motion_plans.origin.with_notice(CHECKED)
    return CheckedPlans(checked, origin), _to_table(checked)


def _check(
    plan: MotionPlan, goals: Goals, space: Space, parameters: CheckCrispPlansParameters
) -> CheckedPlan:
    motion, setup = plan.motion, plan.placed.setup
    steps = len(motion.lengths_mm)
    nothing = np.full(steps, np.nan)
    if plan.status != "planned" and not steps:
        failure = f"there is no motion to check: {plan.reason or plan.status}"
        return CheckedPlan(plan, False, (failure,), (), nothing, nothing)
    nonsense = find_nonsense(motion, setup)
    if nonsense:
        return CheckedPlan(plan, False, tuple(nonsense), (), nothing, nothing)
    fine = cut_finely(motion, parameters.resolution)
    joint_failures, joint_figures = check_joint_steps(motion, parameters)
    failures = check_goal(plan, goals) + check_start(motion, plan.placed)
    failures += check_limits(fine, plan.placed) + joint_failures
    followed = follow_motion(setup, fine, motion.wrenches[0], parameters)
    broken, figures = check_mechanics(plan, fine, followed, parameters)
    failures += broken
    clearances, margins = nothing, nothing
    if len(followed.margins):
        touches = check_touches(setup, fine, followed, space, parameters)
        failures += touches.failures
        figures = touches.figures + figures
        clearances = touches.clearances_mm
        margins = least_at_steps(followed.margins, fine.at[: len(followed.margins)], fine)
    sight_failures, sight_figures = _check_sight(plan, followed, space.cavity, parameters)
    failures += sight_failures
    return CheckedPlan(
        plan, not failures, tuple(failures), tuple(figures + joint_figures + sight_figures),
        clearances, margins,
    )  # fmt: skip


def _check_sight(
    plan: MotionPlan, followed: Followed, cavity: Boxes, parameters: CheckCrispPlansParameters
) -> tuple[list[str], list[Figure]]:
    """Refuse a motion at whose end the goal is not seen."""
    if followed.lost or not len(followed.margins):
        return ["the goal is not seen: the robot does not get to the last step"], []
    if not are_on_surface(plan.cells, cavity):
        return ["a cell of the goal is not on the surface of the free space"], []
    angle = plan.placed.setup.field_of_view_deg
    seen = int(see_cells(followed.cameras[-1], angle, plan.cells, cavity).sum())
    claimed, failures = len(plan.cells), []
    if seen < max(parameters.seen_share * claimed, 1):
        failures.append(
            f"from the last step the camera sees {seen} of the {claimed} cells of the goal that it"
            " was planned to see"
        )
    meaning = f"from the last step, of {claimed} that the planner says are seen"
    return failures, [Figure("cells of the goal seen", float(seen), "", meaning)]


def _to_table(checked: tuple[CheckedPlan, ...]) -> "pandas.DataFrame":
    """Return one row a plan; numbers that were not found are missing."""
    import pandas

    columns = {
        "least_clearance_mm": "least clearance",
        "smallest_stability_margin": "smallest stability margin",
        "largest_turn_deg": "largest turn of a step",
        "largest_shift_mm": "largest shift of a step",
        "camera_way_mm": "way of the camera",
    }
    rows = []
    for each in checked:
        told = {figure.name: figure for figure in each.figures}
        rows.append({
            "goal": each.proposed.goal,
            "setup": each.proposed.placed.name if len(each.proposed.motion.lengths_mm) else "none",
            "verdict": _verdict(each),
            "steps": len(each.proposed.motion.lengths_mm),
            **{column: _value(told, name) for column, name in columns.items()},
            "largest_force_n": _largest(each, "largest force"),
            "largest_moment_n_mm": _largest(each, "largest moment"),
            "reason": "; ".join(each.failures) or "none",
        })  # fmt: skip
    names = ["goal", "setup", "verdict", "steps", *columns, "largest_force_n",
             "largest_moment_n_mm", "reason"]  # fmt: skip
    texts = dict.fromkeys(("goal", "setup", "verdict", "reason"), "str")
    numbers = dict.fromkeys([*columns, "largest_force_n", "largest_moment_n_mm"], float)
    return pandas.DataFrame(rows, columns=names).astype({**texts, "steps": int, **numbers})


def _verdict(each: CheckedPlan) -> str:
    if each.passed:
        return "plan"
    return "refused" if len(each.proposed.motion.lengths_mm) else "no motion"


def _value(told: dict[str, Figure], name: str) -> float:
    return told[name].value if name in told else np.nan


def _largest(each: CheckedPlan, name: str) -> float:
    """Return the largest of the figures whose names begin so; nan without any."""
    return max((f.value for f in each.figures if f.name.startswith(name)), default=np.nan)
