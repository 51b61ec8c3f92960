"""The shape of a robot, in 3-D and in numbers."""

from typing import TYPE_CHECKING

import numpy as np

from nodes.geometry.meshes import Surfaces
from nodes.mechanics.shapes import Figure, RobotShape, Rod
from nodes.reporting.artefacts import Section
from nodes.reporting.honesty import warnings_of
from nodes.reporting.marks import join_meshes, make_arrow, make_ball, sweep_tube
from nodes.reporting.parameters import ShowShapeParameters
from nodes.reporting.scene import SCRIPTS, Mark, render_scene
from nodes.reporting.tables import render_table, to_rows

if TYPE_CHECKING:
    import pandas

TIP, JOINT, FORCE = "#d55e00", "#333333", "#d6007f"
"""Colours of the tip's tangent, the grasps and the forces; no rod has them."""


GIVEN = "For these joint values and this robot:"


def show_shape(robot_shape: RobotShape, parameters: ShowShapeParameters) -> Section:
    """Show the rods of a robot, its tip, grasps and loads, and what the mechanics says of them.

    Parameters
    ----------
    robot_shape : a shape, or why there is none.
    parameters : title, caption, sizes, digits.

    Returns
    -------
    A section that needs the script of the 3-D viewer where there is something to view. A shape that
    is not solved is a warning at the head of the page.
    """
    warnings = warnings_of(robot_shape.origin)
    if robot_shape.status != "solved":
        warnings = (f"{robot_shape.status}: {robot_shape.reason}", *warnings)
    table = render_table(tabulate_figures(robot_shape), "", parameters.decimals, 3)
    if robot_shape.given:
        table += render_table(tabulate(robot_shape.given), GIVEN, parameters.decimals, 3)
    if not robot_shape.rods:
        return Section(parameters.title, table, warnings)
    thicker = draw_thicker(robot_shape.rods, parameters.least_radius_share)
    rods = tuple(
        (rod.name, sweep_tube(rod.points_patient_mm, rod.tangents, thicker * rod.outer_radius_mm))
        for rod in robot_shape.rods
    )
    marks = draw_tip(robot_shape, parameters) + draw_grasps(robot_shape, parameters)
    marks += draw_forces(robot_shape, parameters)
    below = f"<p>Tubes are drawn {thicker:.1f} times as thick as they are.</p>"
    surfaces = Surfaces(rods, robot_shape.origin)
    html = render_scene(surfaces, marks, parameters, below if thicker > 1 else "") + table
    return Section(parameters.title, html, warnings, SCRIPTS)


def draw_thicker(rods: tuple[Rod, ...], least_radius_share: float) -> float:
    """Return the factor, at least 1, by which radii are drawn larger so that the thinnest is seen.

    Parameters
    ----------
    least_radius_share : least radius over the robot's extent, no unit.
    """
    points = np.concatenate([rod.points_patient_mm for rod in rods])
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    return max(1.0, least_radius_share * extent / min(rod.outer_radius_mm for rod in rods))


def tabulate_figures(shape: RobotShape) -> "pandas.DataFrame":
    """Return one row a figure: what it is, its value with unit, what it means."""
    import pandas

    rows = to_rows(shape.figures)
    if shape.patient_from_tip.size:
        place = ", ".join(f"{value:.4f}" for value in shape.patient_from_tip[:3, 3])
        along = ", ".join(f"{value:.6f}" for value in shape.patient_from_tip[:3, 2])
        rows = [
            {"figure": "tip", "value": f"[{place}] mm", "meaning": "place, patient LPS"},
            {"figure": "tip tangent", "value": f"[{along}]", "meaning": "where the tip points"},
            *rows,
        ]
    state = {
        "figure": "status",
        "value": shape.status,
        "meaning": shape.reason or "a shape was found",
    }
    return pandas.DataFrame([state, *rows])


def tabulate(figures: tuple[Figure, ...]) -> "pandas.DataFrame":
    """Return one row a figure of what was given."""
    import pandas

    return pandas.DataFrame(to_rows(figures)).rename(
        columns={"figure": "given", "meaning": "of what"}
    )


def draw_tip(shape: RobotShape, parameters: ShowShapeParameters) -> tuple[Mark, ...]:
    """Return the tip's tangent as an arrow."""
    tip = shape.patient_from_tip
    radius = parameters.axis_length_mm / 30
    arrow = make_arrow(tip[:3, 3], tip[:3, 2], parameters.axis_length_mm, radius)
    return (Mark("tip tangent", arrow, TIP, shine=True),)


def draw_grasps(shape: RobotShape, parameters: ShowShapeParameters) -> tuple[Mark, ...]:
    """Return a ball where each snare grasps; none for a robot without."""
    if not len(shape.joints_patient_mm):
        return ()
    balls = tuple(make_ball(place, parameters.joint_radius_mm) for place in shape.joints_patient_mm)
    return (Mark("grasps", join_meshes(balls), JOINT, shine=True),)


def draw_forces(shape: RobotShape, parameters: ShowShapeParameters) -> tuple[Mark, ...]:
    """Return an arrow to where each force pulls from, its value beside it; moments are left out."""
    arrows, tags = [], []
    for load in shape.loads:
        size = float(np.linalg.norm(load[3:]))
        if size > 0:
            length = size * parameters.force_length_mm_per_n
            arrows.append(make_arrow(load[:3], load[3:], length, parameters.joint_radius_mm / 2))
            end = load[:3] + load[3:] / size * length
            tags.append((f"{size:.3g} N", *map(float, end)))
    return (Mark("forces", join_meshes(tuple(arrows)), FORCE, tuple(tags)),) if arrows else ()
