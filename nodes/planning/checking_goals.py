"""Whether a motion goes to the goal that it names."""

import re

import numpy as np

from nodes.planning.artefacts import Goals, MotionPlan

OF_SEVERAL = re.compile(r" \d+/\d+$")
"""What ends a motion's name where a region takes several."""


def check_goal(plan: MotionPlan, goals: Goals) -> list[str]:
    """Refuse a motion whose goal is none of those asked for, or whose cells are not that goal's."""
    names = [plan.goal, OF_SEVERAL.sub("", plan.goal)]
    known = [name for name in names if name in goals.names]
    if not known:
        return [f"{plan.goal} is none of the goals that were asked for"]
    goal = goals.names.index(known[0])
    failures = [] if plan.status == "planned" else [f"the planner calls it {plan.status}"]
    if not np.array_equal(plan.goal_point_patient_mm, goals.points_patient_mm[goal]):
        failures.append(f"the motion names another point than that of {known[0]}")
    own = set(map(tuple, goals.cells[goals.goals == goal].tolist()))
    claimed = list(map(tuple, plan.cells.tolist()))
    strange = len(set(claimed) - own)
    if strange:
        failures.append(f"{strange} of the {len(claimed)} cells that it sees are not {known[0]}'s")
    if len(set(claimed)) < len(claimed):
        failures.append("it counts a cell of the goal more than once")
    return failures
