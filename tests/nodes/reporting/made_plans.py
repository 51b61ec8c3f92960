"""A small made cavity, an unbent robot, its tree, what it sees, and verdicts on motions."""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.ndimage import binary_dilation, distance_transform_edt
from scipy.spatial.transform import Rotation

from nodes.geometry.grids import Volume
from nodes.geometry.meshes import Surfaces
from nodes.geometry.origin import Origin
from nodes.mechanics.materials import MATERIALS
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, Snare
from nodes.mechanics.shapes import Figure
from nodes.planning.artefacts import (
    CheckedPlan,
    CheckedPlans,
    CrispMotion,
    CrispTree,
    CrispTrees,
    MotionPlan,
    PlacedSetup,
)
from nodes.visibility.artefacts import VisibilitySet, VisibilitySets

CELL_MM = 2.0
HALVES_MM = np.array([40.0, 28.0, 24.0])
ORIGIN = Origin("a made cavity", True, ("Its walls are an ellipsoid.",))
PATIENT_FROM_INDEX = np.diag([CELL_MM, CELL_MM, CELL_MM, 1.0])
SHAPE = tuple(int(2 * half / CELL_MM) + 7 for half in HALVES_MM)
PATIENT_FROM_INDEX[:3, 3] = -CELL_MM * (np.array(SHAPE) - 1) / 2


def make_free() -> np.ndarray:
    """Return which cells' centres lie in the ellipsoid about the patient's origin."""
    indices = np.moveaxis(np.indices(SHAPE), 0, -1)
    points = indices * CELL_MM + PATIENT_FROM_INDEX[:3, 3]
    return ((points / HALVES_MM) ** 2).sum(axis=-1) < 1


def make_distance() -> Volume:
    """Return about how far each centre is from the ellipsoid, positive inside."""
    free = make_free()
    inside, outside = (distance_transform_edt(side, CELL_MM) for side in (free, ~free))
    signed = np.where(free, inside - CELL_MM / 2, CELL_MM / 2 - outside)
    return Volume(signed.astype(np.float32), PATIENT_FROM_INDEX, "mm", ORIGIN)


def make_cells() -> np.ndarray:
    """Return the indices of obstacle cells that share a face with a free one."""
    free = make_free()
    return np.argwhere(binary_dilation(free) & ~free)


def make_setup(name: str = "set-up 1") -> PlacedSetup:
    """Return a tool along +x, which a snare from below meets 10 mm from its tip."""
    needle = Needle(MATERIALS["nitinol"], 0.84, 1.02, np.zeros(3))
    entries = np.array([[-38.0, 0, 0], [0.0, 0, -22]])
    setup = CrispSetup((needle, needle), entries, (Snare(1, 10.0),), 90.0)
    tool = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    start = CrispConfiguration(np.stack([tool, np.eye(3)]), np.array([48.0, 22.0]))
    axes = np.stack([tool[:, 2], [0.0, 0, 1]])
    return PlacedSetup(name, setup, start, axes, np.full(2, 0.8), np.full(2, 5.0), np.full(2, 90.0))


def make_motion(steps: int = 30) -> CrispMotion:
    """Return a motion in which both needles turn together about z by half a radian."""
    placed = make_setup()
    turns = Rotation.from_rotvec(np.linspace(0, 0.5, steps)[:, None] * [0, 0, 1]).as_matrix()
    orientations = turns[:, None] @ placed.start.patient_from_entry[None]
    lengths = np.tile(placed.start.lengths_mm, (steps, 1))
    poses = np.tile(np.eye(4), (steps, 1, 1))
    poses[:, :3, :3] = orientations[:, 0]
    poses[:, :3, 3] = placed.setup.entry_points_patient_mm[0] + 48 * orientations[:, 0, :, 2]
    return CrispMotion(orientations, lengths, np.zeros((steps, 2, 6)), poses)


def make_plan(goal: str = "nodule") -> CheckedPlan:
    """Return a plan that passed its check; the goal is where +x leaves the cavity."""
    motion = make_motion()
    steps = len(motion.lengths_mm)
    proposed = MotionPlan(
        goal, np.array([40.0, 2.0, 0.0]), np.array([[42, 18, 15]]), make_setup(), "planned", "",
        motion, (Figure("length of the way", 31.5, "mm", "of the camera, after it was shortened"),),
    )  # fmt: skip
    figures = (Figure("least clearance", 1.25, "mm", "between needles and anatomy"),)
    clearances = 1.25 + np.abs(np.linspace(-2, 3, steps))
    return CheckedPlan(proposed, True, (), figures, clearances, np.linspace(1, 0.4, steps))


def refuse(plan: CheckedPlan, goal: str = "rib") -> CheckedPlan:
    """Return the same motion with a verdict against it."""
    proposed = replace(plan.proposed, goal=goal)
    failures = ("step 12 touches a cell that is not free",)
    return replace(plan, proposed=proposed, passed=False, failures=failures)


def lose(plan: CheckedPlan, goal: str = "apex") -> CheckedPlan:
    """Return that there is no motion to a goal."""
    none = CrispMotion(np.zeros((0, 2, 3, 3)), np.zeros((0, 2)), np.zeros((0, 2, 6)),
                       np.zeros((0, 4, 4)))  # fmt: skip
    proposed = replace(
        plan.proposed, goal=goal, status="not seen", reason="no node of the tree sees it",
        motion=none, cells=np.zeros((0, 3), int), figures=(),
    )  # fmt: skip
    nothing = np.zeros(0)
    return CheckedPlan(proposed, False, (), (), nothing, nothing)


def make_plans() -> CheckedPlans:
    """Return a plan that passed, one that was refused, and a goal without motion."""
    plan = make_plan()
    return CheckedPlans((plan, refuse(plan), lose(plan)), ORIGIN)


def make_tree(name: str = "set-up 1") -> CrispTree:
    """Return a tree along the motion, a node each step."""
    placed, motion = make_setup(name), make_motion()
    nodes = len(motion.lengths_mm)
    quaternions = np.stack([
        Rotation.from_matrix(turns).as_quat(scalar_first=True) for turns in motion.orientations
    ])  # fmt: skip
    return CrispTree(
        placed, np.arange(nodes) - 1, quaternions, motion.lengths_mm, np.full(nodes, 2),
        motion.wrenches, motion.patient_from_camera[:, :3, 3], motion.patient_from_camera[:, :3, 2],
        np.linspace(0.001, 3, nodes), np.zeros(nodes, int), np.zeros(0, int), "node limit", (),
    )  # fmt: skip


def make_trees(*names: str) -> CrispTrees:
    """Return a tree for each set-up."""
    return CrispTrees(tuple(make_tree(name) for name in names), ORIGIN)


def make_sets(*names: str) -> VisibilitySets:
    """Return set-ups that see the cells right of -10 n mm, later the farther left they are."""
    cells = make_cells()
    x = cells[:, 0] * CELL_MM + PATIENT_FROM_INDEX[0, 3]
    sets = []
    for place, name in enumerate(names):
        first = np.where(x > -10 * place, np.clip((40 - x) / 2, 0, 29).astype(int), -1)
        sets.append(VisibilitySet(name, first, np.linspace(0.002, 4, 30)))
    return VisibilitySets(cells, PATIENT_FROM_INDEX, SHAPE, "own ray", tuple(sets), ORIGIN)


def make_table(sets: VisibilitySets) -> pd.DataFrame:
    """Return one row a set-up."""
    shares = [float((one.first_nodes >= 0).mean()) for one in sets.sets]
    return pd.DataFrame({"name": [one.name for one in sets.sets], "share_seen": shares})


def make_anatomy(balls: Surfaces) -> Surfaces:
    """Return the surfaces of a test, honest about being made."""
    return replace(balls, origin=ORIGIN)
