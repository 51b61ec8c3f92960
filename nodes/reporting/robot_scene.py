"""CRISP robots in a 3-D view: needles at rest or in motion, sheaths, the camera's cone, goals."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.meshes import Mesh
from nodes.mechanics.crisp_arrays import to_grasps
from nodes.mechanics.robots import CrispSetup
from nodes.mechanics.sample_crisp_needles import sample_crisp_needles
from nodes.planning.artefacts import CrispTree
from nodes.reporting.marks import frame_along, turn_profile
from nodes.reporting.parameters import ShowRobotsParameters
from nodes.reporting.scene import MovingBody, MovingTubes, Shown

TOOL, SNARES, SHEATHS, CONE = "#1b9e77", ("#7570b3", "#d95f02", "#a6761d"), "#666666", "#ffd54a"
"""Colours of the tool, the snares in their order, the sheaths and the camera's cone; all but the
last are of one palette that people with colour-blindness tell apart."""

SHEATH_RADII = 1.6
"""Radius of a sheath as it is drawn, in radii of its needle."""


@dataclass(frozen=True)
class RobotSteps:
    """Configurations of a CRISP robot in order, as they are drawn.

    Parameters
    ----------
    orientations, lengths_mm, wrenches : as of a motion.
    patient_from_camera : (step, 4, 4).
    """

    setup: CrispSetup
    orientations: Float[np.ndarray, "step needle 3 3"]
    lengths_mm: Float[np.ndarray, "step needle"]
    wrenches: Float[np.ndarray, "step needle 6"]
    patient_from_camera: Float[np.ndarray, "step 4 4"]


def take_start(tree: CrispTree) -> RobotSteps:
    """Return the configuration at a tree's root as a motion of one step.

    The camera's roll is left open: its cone is round.
    """
    placed = tree.placed
    pose = np.eye(4)
    pose[:3, :3] = frame_along(tree.views[0])
    pose[:3, 3] = tree.cameras_patient_mm[0]
    return RobotSteps(
        placed.setup,
        placed.start.patient_from_entry[None],
        placed.start.lengths_mm[None],
        tree.wrenches[:1],
        pose[None],
    )


def draw_robot(
    steps: RobotSteps,
    thicker: float,
    choice: int | None,
    parameters: ShowRobotsParameters,
) -> tuple[Shown, ...]:
    """Return needles, sheaths and the camera's cone of a robot in motion; one step is a rest.

    Parameters
    ----------
    thicker : by which needles are drawn thicker than they are.
    choice : of the scene, with which it is shown.
    """
    setup = steps.setup
    points = sample_crisp_needles(
        setup, steps.orientations, steps.lengths_mm, steps.wrenches, parameters.pieces
    )
    radii = [thicker * needle.radius_mm for needle in setup.needles]
    shown: list[Shown] = [
        MovingTubes("camera tube", points.tool_patient_mm[:, None], radii[0], TOOL, choice)
    ]
    for place, snare in enumerate(to_grasps(setup, float(steps.lengths_mm[0, 0])).snare.tolist()):
        colour = SNARES[(snare - 1) % len(SNARES)]
        curve = points.snares_patient_mm[:, place : place + 1]
        shown.append(
            MovingTubes(name_needle(setup, snare), curve, radii[snare], colour, choice, True)
        )
    shown.append(draw_sheaths(steps, max(radii), choice, parameters))
    cone = make_cone(setup.field_of_view_deg, parameters.cone_mm)
    opacity = parameters.cone_opacity
    shown.append(
        MovingBody("field of view", cone, steps.patient_from_camera, CONE, opacity, choice)
    )
    return tuple(shown)


def draw_sheaths(
    steps: RobotSteps, radius_mm: float, choice: int | None, parameters: ShowRobotsParameters
) -> MovingTubes:
    """Return a straight tube backwards from each entry point, as far as it stands outside."""
    entries = np.broadcast_to(steps.setup.entry_points_patient_mm, (*steps.lengths_mm.shape, 3))
    behind = entries - parameters.outside_mm * steps.orientations[..., 2]
    curves = np.stack([behind, entries], axis=2)
    return MovingTubes("sheaths", curves, SHEATH_RADII * radius_mm, SHEATHS, choice)


def name_needle(setup: CrispSetup, needle: int) -> str:
    """Return what pages call a needle."""
    if needle == 0:
        return "camera tube"
    return f"snare {needle}" if len(setup.needles) > 2 else "snare"


def make_cone(field_of_view_deg: float, length_mm: float) -> Mesh:
    """Return the cone of a camera at the origin that looks along +z, open to no side.

    Its base is a part of a ball, so that wide angles, too, are drawn as they are.
    """
    half = np.radians(field_of_view_deg / 2)
    angles = np.linspace(half, 0, 6)
    cap = length_mm * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    profile = np.concatenate([[[0.0, 0.0]], cap])
    return turn_profile(np.zeros(3), np.array([0.0, 0.0, 1.0]), profile)


def choose_thickness(
    points_mm: Float[np.ndarray, "n 3"], setups: tuple[CrispSetup, ...], least_radius_share: float
) -> float:
    """Return the factor, at least 1, by which needles are drawn thicker so that each is seen.

    Parameters
    ----------
    points_mm : what is in the picture.
    least_radius_share : least radius over the picture's extent, no unit.
    """
    extent = float(np.linalg.norm(np.ptp(points_mm, axis=0)))
    thinnest = min(needle.radius_mm for setup in setups for needle in setup.needles)
    return max(1.0, least_radius_share * extent / thinnest)


def tell_thickness(thicker: float) -> str:
    """Return a fragment that says by how much needles are drawn thicker, or nothing."""
    if thicker <= 1:
        return ""
    return f'<p class="hint">Needles are drawn {thicker:.1f} times as thick as they are.</p>'


def choose_steps(count: int, most: int) -> list[int]:
    """Return at most so many of the steps of a motion, evenly, the first and the last included."""
    return np.unique(np.rint(np.linspace(0, count - 1, min(count, most))).astype(int)).tolist()
