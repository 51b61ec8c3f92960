"""Trees of one set-up that grow side by side, and become one."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Int

from nodes.mechanics.crisp_lane_groups import Problem, pose_problem
from nodes.planning.artefacts import CrispTree, Ending, PlacedSetup
from nodes.planning.clock import now
from nodes.planning.parameters import GrowCrispTreesParameters
from nodes.planning.tree_memory import (
    Sizes,
    make_front,
    make_nodes,
    make_poses,
    make_room,
    make_sights,
    widen_nodes,
    widen_poses,
)
from nodes.planning.tree_merge import merge_trees
from nodes.planning.tree_start import solve_start
from nodes.planning.tree_task import make_sizes, make_task

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Space
    from nodes.kernels.crisp_tree import Nodes, Room, Task
    from nodes.kernels.crisp_tree_front import Front
    from nodes.kernels.crisp_tree_views import Sights
    from nodes.kernels.nearest_poses import Poses

FIRST_NODES = 1 << 22  # room that is asked for at once; what is not used costs nothing
TOGETHER = 8  # rounds after which trees see whether they saw all goals; so it never depends on time
SLICE_S = 0.01  # between two looks at the clock, about


@dataclass
class Growth:
    """One tree as it grows.

    Parameters
    ----------
    rounds : in one call of the kernel, as the clock finds it right.
    times, counts : when the clock was read, and how many nodes there were then.
    """

    sizes: Sizes
    task: "Task"
    nodes: "Nodes"
    poses: "Poses"
    front: "Front"
    sights: "Sights"
    room: "Room"
    rounds: int = 1
    has_ended: bool = False
    times: list[float] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)

    def advance(self, rounds: int) -> None:
        """Go on for so many rounds, or to the last node."""
        from nodes.kernels.crisp_tree import HAS_ENDED, IS_FULL, grow

        state = IS_FULL
        while state == IS_FULL:
            state, done = grow(
                self.task, self.nodes, self.poses, self.front, self.sights, self.room, rounds
            )
            rounds -= done
            if state == IS_FULL:
                self._widen()
        self.has_ended = state == HAS_ENDED
        self.times.append(now())
        self.counts.append(int(self.nodes.size[0]))

    def run(self, end: float) -> None:
        """Go on until a time or the last node."""
        began = now()
        while not self.has_ended and began < end:
            self.advance(self.rounds)
            took, began = now() - began, now()
            if took < SLICE_S / 2:
                self.rounds *= 2
            elif took > SLICE_S and self.rounds > 1:
                self.rounds //= 2

    def _widen(self) -> None:
        from nodes.kernels.crisp_lanes import LANES

        needles = self.sizes.needles
        if self.nodes.size[0] + LANES > len(self.nodes.parents):
            self.nodes = widen_nodes(self.nodes, self.sizes, 2 * len(self.nodes.parents))
        if self.poses.sizes[1] + LANES > len(self.poses.filled):
            self.poses = widen_poses(self.poses, needles)


def grow_tree(
    placed: PlacedSetup,
    cavity: "Space",
    wall: "Space",
    cells: Int[np.ndarray, "cell 3"],
    parameters: GrowCrispTreesParameters,
) -> CrispTree:
    """Return the tree of one set-up.

    Parameters
    ----------
    cavity, wall : of make_cavity and make_wall.
    cells : indices in the cavity of all cells that the goals have.

    Raises
    ------
    BadInput : if the start cannot be solved or touches anything; if needles are curved, or joints
        pass one another on the tool.
    """
    problem = pose_problem(placed.setup, placed.start.lengths_mm[None])
    wrenches, camera = solve_start(placed, cavity, wall, parameters)
    start = wrenches[problem.robot.snare] / problem.wrench_unit, camera
    spaces = cavity, wall
    growths = [
        _plant(placed, problem, start, spaces, cells, parameters, tree)
        for tree in range(parameters.trees)
    ]
    began = now()
    ending = _grow_all(growths, began + parameters.time_limit_s, parameters)
    return merge_trees(placed, problem, growths, began, ending)


def _plant(
    placed: PlacedSetup,
    problem: Problem,
    start: tuple[np.ndarray, np.ndarray],
    spaces: tuple["Space", "Space"],
    cells: Int[np.ndarray, "cell 3"],
    parameters: GrowCrispTreesParameters,
    tree: int,
) -> Growth:
    """Return a tree that is its start alone; all kernels are compiled then."""
    from nodes.kernels.crisp_lanes import LANES
    from nodes.kernels.crisp_tree import grow, plant

    most = 1 + len(range(tree, parameters.node_limit - 1, parameters.trees))
    sizes, room_for = make_sizes(placed, parameters), min(most, FIRST_NODES) + LANES
    chance = np.random.SeedSequence(parameters.seed).spawn(tree + 1)[tree]
    growth = Growth(
        sizes,
        make_task(placed, problem, start[0], spaces, parameters, most),
        make_nodes(room_for, sizes),
        make_poses(room_for, sizes.needles),
        make_front(sizes),
        make_sights(cells, placed.setup.field_of_view_deg),
        make_room(sizes, int(chance.generate_state(1, np.uint64)[0])),
    )
    _write_start(placed, problem, start, growth.nodes)
    plant(growth.task, growth.nodes, growth.poses, growth.sights, growth.room)
    grow(growth.task, growth.nodes, growth.poses, growth.front, growth.sights, growth.room, 0)
    return growth


def _write_start(
    placed: PlacedSetup, problem: Problem, start: tuple[np.ndarray, np.ndarray], nodes: "Nodes"
) -> None:
    from scipy.spatial.transform import Rotation

    wrenches, camera = start
    turns = Rotation.from_matrix(placed.start.patient_from_entry)
    nodes.quaternions[0] = turns.as_quat(scalar_first=True)
    nodes.lengths[0] = placed.start.lengths_mm
    nodes.wrenches[0] = wrenches.ravel()
    place = (camera[:3, 3] - placed.setup.entry_points_patient_mm[0]) / problem.unit_mm
    nodes.tips[0] = np.concatenate([place, camera[:3, 2], camera[:3, 0]])


def _grow_all(growths: list[Growth], end: float, parameters: GrowCrispTreesParameters) -> Ending:
    """Grow all trees, each in a thread, and return why that ended."""
    for_goals = parameters.stop_when_seen and len(growths[0].sights.cells) > 0
    with ThreadPoolExecutor(len(growths)) as pool:
        if not for_goals:
            list(pool.map(lambda growth: growth.run(end), growths))
        while for_goals and not all(growth.has_ended for growth in growths):
            if _have_seen_all(growths):
                return "goals seen"
            if now() >= end:
                return "time limit"
            list(pool.map(lambda growth: growth.advance(TOGETHER), growths))
    if for_goals and _have_seen_all(growths):
        return "goals seen"
    return "node limit" if all(growth.has_ended for growth in growths) else "time limit"


def _have_seen_all(growths: list[Growth]) -> bool:
    return bool(np.max([growth.sights.seeing for growth in growths], axis=0).min() >= 0)
