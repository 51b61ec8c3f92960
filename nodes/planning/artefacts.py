"""What planning makes: set-ups in a patient, goals, trees of motions, plans and verdicts."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.origin import Origin
from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.mechanics.shapes import Figure


@dataclass(frozen=True)
class PlacedSetup:
    """A set-up in a patient, and where its robot starts.

    Parameters
    ----------
    name : as tables and pages call it.
    setup : needles, entry points, grasps, camera.
    start : the configuration from which every motion begins; no loads.
    axes : (needle, 3) unit vectors in patient axes, about which needles may tilt.
    largest_tilts_rad : (needle,) how far a needle's tangent at its entry may turn from its axis.
    shortest_mm, longest_mm : (needle,) limits of the lengths beyond the entry points.
    entries : rows' `number` in the table of entries, the tool's first; empty where a person chose.
    """

    name: str
    setup: CrispSetup
    start: CrispConfiguration
    axes: Float[np.ndarray, "needle 3"]
    largest_tilts_rad: Float[np.ndarray, "needle"]
    shortest_mm: Float[np.ndarray, "needle"]
    longest_mm: Float[np.ndarray, "needle"]
    entries: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class PlacedSetups:
    """Set-ups that are to be compared or planned with, the best first where they were searched."""

    setups: tuple[PlacedSetup, ...]
    origin: Origin


@dataclass(frozen=True)
class Goals:
    """Places on the surface of the free space that the camera has to see.

    Parameters
    ----------
    names : of the goals; a goal is one cell (a point) or many (a painted region).
    cells : (cell, 3) indices of boundary cells in the occupancy grid.
    goals : (cell,) to which goal, as place in `names`, each cell belongs.
    points_patient_mm : (goal, 3) the point that was asked for, or the cell nearest to the region's
        middle, patient LPS mm.
    """

    names: tuple[str, ...]
    cells: Int[np.ndarray, "cell 3"]
    goals: Int[np.ndarray, "cell"]
    points_patient_mm: Float[np.ndarray, "goal 3"]
    origin: Origin

    def __post_init__(self) -> None:
        freeze_arrays(self)


Ending = Literal["time limit", "node limit", "goals seen"]


@dataclass(frozen=True)
class CrispTree:
    """Configurations that a robot reaches from its start without touching anything, as a tree.

    Node 0 is the start. The edge to a node runs from its parent: orientations turn at constant
    speed (SLERP), lengths change evenly, in `steps` steps, each of which was solved and checked.

    Parameters
    ----------
    placed : the set-up, and the start.
    parents : (node,) -1 for the start, else the place of an earlier node.
    quaternions : (node, needle, 4) w, x, y, z of patient_from_entry.
    lengths_mm : (node, needle).
    steps : (node,) of the edge from the parent; 0 for the start.
    wrenches : (node, needle, 6) moment, N mm, and force, N, at the entry points, patient axes.
    cameras_patient_mm, views : (node, 3) place of the camera, and the unit vector that it looks
        along.
    seconds : (node,) since growing began, when the node was there; the only field that depends on
        the clock, besides where growing was ended by it.
    trees : (node,) by which of the trees that grow side by side it was found.
    seeing : (goal cell,) the first node that sees each cell of the goals, or -1; no goals, no cell.
    ending : why growing ended.
    counts : edges tried, steps solved, collisions and so on, with what each means.
    """

    placed: PlacedSetup
    parents: Int[np.ndarray, "node"]
    quaternions: Float[np.ndarray, "node needle 4"]
    lengths_mm: Float[np.ndarray, "node needle"]
    steps: Int[np.ndarray, "node"]
    wrenches: Float[np.ndarray, "node needle 6"]
    cameras_patient_mm: Float[np.ndarray, "node 3"]
    views: Float[np.ndarray, "node 3"]
    seconds: Float[np.ndarray, "node"]
    trees: Int[np.ndarray, "node"]
    seeing: Int[np.ndarray, "cell"]
    ending: Ending
    counts: tuple[Figure, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class CrispTrees:
    """One tree a set-up."""

    trees: tuple[CrispTree, ...]
    origin: Origin


@dataclass(frozen=True)
class CrispMotion:
    """Configurations of a CRISP robot in order, the start first; empty where none was found.

    Parameters
    ----------
    orientations : (step, needle, 3, 3) patient_from_entry.
    lengths_mm : (step, needle).
    wrenches : (step, needle, 6) moment, N mm, and force, N, at the entry points.
    patient_from_camera : (step, 4, 4) rigid, mm; z is the direction of view.
    """

    orientations: Float[np.ndarray, "step needle 3 3"]
    lengths_mm: Float[np.ndarray, "step needle"]
    wrenches: Float[np.ndarray, "step needle 6"]
    patient_from_camera: Float[np.ndarray, "step 4 4"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class MotionPlan:
    """A motion to where the camera sees a goal, or why there is none.

    Parameters
    ----------
    goal : its name.
    goal_point_patient_mm : (3,) patient LPS mm.
    cells : (cell, 3) the goal's cells that its last configuration sees, as indices of the grid.
    placed : the set-up.
    status : "planned": the planner found it; whether it is a plan says the verdict of the check.
    reason : why there is no motion; empty if there is.
    motion : evenly cut.
    figures : length of the way before and after it was shortened, steps.
    """

    goal: str
    goal_point_patient_mm: Float[np.ndarray, "3"]
    cells: Int[np.ndarray, "cell 3"]
    placed: PlacedSetup
    status: Literal["planned", "not seen", "unreachable"]
    reason: str
    motion: CrispMotion
    figures: tuple[Figure, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class MotionPlans:
    """Plans to all goals, as the planner found them; not checked."""

    plans: tuple[MotionPlan, ...]
    origin: Origin


@dataclass(frozen=True)
class CheckedPlan:
    """A motion with the verdict of a check that shares no code with the planner.

    Parameters
    ----------
    proposed : what the planner found.
    passed : whether it may be called a plan.
    failures : what it broke, each a sentence; empty if it passed.
    figures : least clearance, least stability margin, largest wrench, largest joint step, ...
    clearances_mm, margins : (step,) along the motion's own steps: between needles and anatomy, and
        stability margin without unit.
    """

    proposed: MotionPlan
    passed: bool
    failures: tuple[str, ...]
    figures: tuple[Figure, ...]
    clearances_mm: Float[np.ndarray, "step"]
    margins: Float[np.ndarray, "step"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class CheckedPlans:
    """Verdicts on the plans to all goals."""

    plans: tuple[CheckedPlan, ...]
    origin: Origin
