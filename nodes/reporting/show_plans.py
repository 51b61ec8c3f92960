"""Plans of motions: the robot in 3-D along them, its camera's view, and what their check said."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from nodes.geometry.camera_views import soften_distance
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import Volume
from nodes.geometry.meshes import Surfaces
from nodes.planning.artefacts import CheckedPlan, CheckedPlans
from nodes.reporting.artefacts import Section
from nodes.reporting.camera_pictures import Tissues, draw_view, gather_tissues, is_in_view
from nodes.reporting.cavity_surface import draw_cavity
from nodes.reporting.charts import Chart, Curve, render_chart
from nodes.reporting.embedding import encode_base64
from nodes.reporting.honesty import warnings_of
from nodes.reporting.marks import join_meshes, make_ball, sweep_line
from nodes.reporting.mosaics import encode_webp
from nodes.reporting.parameters import ShowPlansParameters
from nodes.reporting.rendering import render_template
from nodes.reporting.robot_scene import (
    RobotSteps,
    choose_steps,
    choose_thickness,
    draw_robot,
    tell_thickness,
)
from nodes.reporting.scene import SCRIPTS, Choice, Mark, Shown, render_scene
from nodes.reporting.tables import render_table, tabulate_figures

if TYPE_CHECKING:
    import pandas

GOAL, WAY = "#d6007f", "#c07d00"
"""Colours of the goal and of the camera's way; no needle has them."""

MODEL = "Computed by models of anatomy and mechanics, not measured."


def show_plans(
    checked_plans: CheckedPlans,
    distance_field: Volume,
    surfaces: Surfaces,
    parameters: ShowPlansParameters,
) -> Section:
    """Show each motion with the verdict of its check: in 3-D, through the camera, and in curves.

    Parameters
    ----------
    checked_plans : motions and verdicts; what a check refused is never called a plan.
    distance_field : signed distance to the walls of the space in which they are, mm.
    surfaces : of the anatomy around it.
    parameters : what is shown, sizes, pictures.

    Returns
    -------
    A section that needs the script of the 3-D viewer. Each refused motion is a warning at the head
    of the page.
    """
    plans = checked_plans.plans
    drawn = tuple(sorted(plans, key=rank))[: parameters.most_motions]
    tissues = gather_tissues(surfaces, parameters.tissue_mm)
    decimals = parameters.decimals
    smooth = soften_distance(distance_field, parameters.smoothing_mm)
    values = {
        "summary": render_table(summarise(plans), tell_rest(plans, parameters), decimals, decimals),
        "plans": [
            describe(plan, smooth, tissues, parameters) | {"name": name}
            for plan, name in zip(drawn, name_choices(drawn), strict=True)
        ],
        "scene": render_motions(drawn, distance_field, surfaces, parameters),
        "pixels": parameters.pixels,
    }
    refused = tuple(
        f"{plan.proposed.goal}: the motion to it was refused by the independent check"
        for plan in plans
        if plan.proposed.status == "planned" and not plan.passed
    )
    warnings = refused + warnings_of(checked_plans.origin)
    scripts = SCRIPTS if drawn else ()
    return Section(parameters.title, render_template("plans.html", values), warnings, scripts)


def tell_verdict(plan: CheckedPlan) -> tuple[str, str, str]:
    """Return the kind of a verdict, its heading, and a sentence for a reader."""
    proposed = plan.proposed
    if proposed.status != "planned":
        return "none", f"No motion to {proposed.goal}", begin_sentence(proposed.reason)
    if plan.passed:
        head = f"Plan to {proposed.goal}: passed the independent check"
        return "passed", head, f"With {proposed.placed.name}. {MODEL}"
    words = f"This is no plan. What the planner proposed with {proposed.placed.name} broke:"
    return "refused", f"Refused by the independent check: motion to {proposed.goal}", words


VERDICTS = {"passed": "plan, passed", "refused": "refused, no plan", "none": "no motion"}


def rank(plan: CheckedPlan) -> int:
    """Return where a motion stands among those that are drawn: plans first, what is none last."""
    return list(VERDICTS).index(tell_verdict(plan)[0])


def begin_sentence(words: str) -> str:
    """Return words with a capital at the beginning and a point at the end."""
    return f"{words[:1].upper()}{words[1:]}".rstrip(".") + "."


def summarise(plans: tuple[CheckedPlan, ...]) -> "pandas.DataFrame":
    """Return one row a motion: goal, verdict, steps, least clearance and margin."""
    import pandas

    rows = []
    for plan in plans:
        proposed = plan.proposed
        x, y, z = map(float, proposed.goal_point_patient_mm)
        steps = len(proposed.motion.lengths_mm) or None
        rows.append({
            "goal": proposed.goal,
            "place in LPS_mm": f"[{x:.1f}, {y:.1f}, {z:.1f}]",
            "verdict of the check": VERDICTS[tell_verdict(plan)[0]],
            "set-up": proposed.placed.name if steps else None,
            "steps": steps,
            "least_clearance_mm": find_least(plan.clearances_mm),
            "least stability margin": find_least(plan.margins),
        })  # fmt: skip
    return pandas.DataFrame(rows, dtype=object)


def find_least(values: Float[np.ndarray, "step"]) -> float:
    """Return the least of those values that are known, nan if none is."""
    known = values[np.isfinite(values)]
    return float(known.min()) if len(known) else np.nan


def tell_rest(plans: tuple[CheckedPlan, ...], parameters: ShowPlansParameters) -> str:
    """Return which of the plans are not drawn, or nothing."""
    if not plans:
        return "There is no goal."
    if len(plans) <= parameters.most_motions:
        return ""
    return f"The first {parameters.most_motions} of {len(plans)} are drawn below."


def describe(
    plan: CheckedPlan, smooth: Volume, tissues: Tissues, parameters: ShowPlansParameters
) -> dict[str, object]:
    """Return what the template says of one plan."""
    kind, verdict, words = tell_verdict(plan)
    decimals = parameters.decimals
    figures = tabulate_figures(plan.figures + plan.proposed.figures)
    return {
        "kind": kind,
        "verdict": verdict,
        "words": words,
        "failures": plan.failures if kind == "refused" else (),
        "charts": draw_charts(plan) if np.isfinite(plan.clearances_mm).any() else (),
        "pictures": draw_pictures(plan, smooth, tissues, parameters),
        "figures": render_table(figures, MODEL, decimals, decimals) if len(figures) else "",
    }


def name_choices(plans: tuple[CheckedPlan, ...]) -> list[str]:
    """Return the plans' names among the choices, which tell their verdicts.

    A region may have several motions, each to another part of it; they are counted.
    """
    goals = [plan.proposed.goal for plan in plans]
    names = []
    for place, plan in enumerate(plans):
        goal, others = goals[place], goals.count(goals[place])
        number = f", motion {goals[: place + 1].count(goal)} of {others}" if others > 1 else ""
        names.append(f"{goal}{number}: {VERDICTS[tell_verdict(plan)[0]]}")
    return names


def draw_charts(plan: CheckedPlan) -> tuple[str, ...]:
    """Return the curves of clearance and stability margin along a motion."""
    steps = np.arange(len(plan.clearances_mm), dtype=float)
    clearance = Chart(
        "Clearance between needles and anatomy", "step", "clearance in mm",
        (Curve("", steps, plan.clearances_mm),),
        ((0.0, "touches"),), follows=True,
    )  # fmt: skip
    margin = Chart(
        "Stability margin", "step", "margin, no unit",
        (Curve("", steps, plan.margins, 1),),
        ((0.0, "unstable"),), follows=True,
    )  # fmt: skip
    return render_chart(clearance), render_chart(margin)


def draw_pictures(
    plan: CheckedPlan, smooth: Volume, tissues: Tissues, parameters: ShowPlansParameters
) -> list[dict[str, object]]:
    """Return the camera's view at steps along a motion, the last one where it ends."""
    motion, proposed = plan.proposed.motion, plan.proposed
    count = len(motion.lengths_mm)
    if not count:
        return []
    shown = choose_steps(count, parameters.most_steps)
    angle = proposed.placed.setup.field_of_view_deg
    goal = proposed.goal_point_patient_mm[None]
    pictures = []
    for place in choose_steps(len(shown), parameters.pictures):
        pose = motion.patient_from_camera[shown[place]]
        view = draw_view(smooth, tissues, pose, angle, goal, parameters.pixels, parameters.near_mm)
        data = encode_base64(encode_webp(view, parameters.quality))
        pictures.append({
            "step": place,
            "source": f"data:image/webp;base64,{data}",
            "text": tell_view(plan, shown[place]),
        })  # fmt: skip
    return pictures


def tell_view(plan: CheckedPlan, step: int) -> str:
    """Return what a camera picture is told by: the step, and where the goal is."""
    proposed, motion = plan.proposed, plan.proposed.motion
    pose, goal = motion.patient_from_camera[step], proposed.goal_point_patient_mm
    inside = is_in_view(pose, proposed.placed.setup.field_of_view_deg, goal[None])[0]
    where = "goal in the cone" if inside else "goal beyond the cone"
    if plan.passed and step == len(motion.lengths_mm) - 1:
        where = "goal seen"
    away = np.linalg.norm(goal - pose[:3, 3])
    return f"step {step + 1} of {len(motion.lengths_mm)}: {where}, {away:.0f} mm away"


def render_motions(
    plans: tuple[CheckedPlan, ...],
    distance_field: Volume,
    surfaces: Surfaces,
    parameters: ShowPlansParameters,
) -> str:
    """Return the 3-D view of all motions, of which the reader chooses one."""
    if not plans:
        return ""
    cavity = draw_cavity(distance_field, parameters.cell_mm, parameters.smoothing_mm)
    chosen = tuple(pair for pair in surfaces.meshes if pair[0] in parameters.shown)
    parts = Surfaces((("cavity", cavity), *chosen), surfaces.origin)
    setups = tuple(plan.proposed.placed.setup for plan in plans)
    extent = [mesh.vertices_patient_mm for _, mesh in parts.meshes]
    thicker = choose_thickness(np.concatenate(extent), setups, parameters.least_radius_share)
    affine = distance_field.patient_from_index
    marks = tuple(
        mark
        for choice, plan in enumerate(plans)
        for mark in draw_motion(plan, choice, thicker, affine, parameters)
    )
    choices = tuple(
        Choice(name, tell_steps(plan, parameters))
        for name, plan in zip(name_choices(plans), plans, strict=True)
    )
    screen = render_template("camera_screen.html", {})
    below = tell_thickness(thicker)
    return render_scene(parts, marks, parameters, below, choices, screen)


def draw_motion(
    plan: CheckedPlan,
    choice: int,
    thicker: float,
    patient_from_index: np.ndarray,
    parameters: ShowPlansParameters,
) -> tuple[Shown, ...]:
    """Return a goal, and the robot and its camera's way where there is a motion."""
    proposed, motion = plan.proposed, plan.proposed.motion
    ball = make_ball(proposed.goal_point_patient_mm, parameters.goal_radius_mm)
    tag = (proposed.goal, *map(float, proposed.goal_point_patient_mm))
    marks: list[Shown] = [Mark("goal", ball, GOAL, (tag,), shine=True, choice=choice)]
    if len(proposed.cells) > 1:
        places = transform_points(patient_from_index, proposed.cells.astype(float))
        dots = tuple(make_ball(place, parameters.goal_radius_mm / 4) for place in places)
        marks.append(Mark("seen of the goal", join_meshes(dots), GOAL, choice=choice))
    if not len(motion.lengths_mm):
        return tuple(marks)
    shown = choose_steps(len(motion.lengths_mm), parameters.most_steps)
    steps = RobotSteps(
        proposed.placed.setup,
        motion.orientations[shown],
        motion.lengths_mm[shown],
        motion.wrenches[shown],
        motion.patient_from_camera[shown],
    )
    marks += draw_robot(steps, thicker, choice, parameters)
    way = sweep_line(motion.patient_from_camera[shown, :3, 3], parameters.way_radius_mm)
    marks.append(Mark("camera's way", way, WAY, choice=choice))
    return tuple(marks)


def tell_steps(plan: CheckedPlan, parameters: ShowPlansParameters) -> tuple[str, ...]:
    """Return what is said at each drawn step of a motion."""
    motion = plan.proposed.motion
    count = len(motion.lengths_mm)
    if not count:
        return ()
    return tuple(
        tell_step(plan, step, count) for step in choose_steps(count, parameters.most_steps)
    )


def tell_step(plan: CheckedPlan, step: int, count: int) -> str:
    """Return what is said at one step."""
    text = f"step {step + 1} of {count}"
    if len(plan.clearances_mm) == count and np.isfinite(plan.clearances_mm[step]):
        text += f", clearance {plan.clearances_mm[step]:.1f} mm"
    return text
