"""Arrays in which a tree of CRISP configurations grows."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nodes.geometry.lines_of_sight import half_view

if TYPE_CHECKING:
    from nodes.kernels.crisp_tree import Nodes, Room
    from nodes.kernels.crisp_tree_front import Front
    from nodes.kernels.crisp_tree_views import Sights
    from nodes.kernels.nearest_poses import Poses

POSES_A_LEAF = 6  # of sixteen at most; with fewer, more leaves are made as they are needed
COUNTS = 12  # what the kernels count


class Sizes(NamedTuple):
    """Of one robot: needles, joints, pieces of each needle, and steps that are solved in one go."""

    needles: int
    joints: int
    pieces: int
    chunk: int


def make_nodes(count: int, sizes: Sizes) -> "Nodes":
    """Return room for so many nodes."""
    from nodes.kernels.crisp_tree import Nodes

    return Nodes(
        np.full(count, -1, np.int64),
        np.zeros(count, np.int64),
        np.zeros((count, sizes.needles, 4)),
        np.zeros((count, sizes.needles)),
        np.zeros((count, 6 * sizes.joints)),
        np.zeros((count, 9)),
        np.zeros(count, np.uint8),
        np.zeros(1, np.int64),
    )


def make_poses(count: int, needles: int) -> "Poses":
    """Return room for about so many poses."""
    from nodes.kernels.crisp_lanes import LANES, make_lanes
    from nodes.kernels.nearest_poses import DEEPEST, ROWS, Poses

    leaves, rows = count // POSES_A_LEAF + 2 * LANES, ROWS * needles
    return Poses(
        make_lanes(leaves * rows),
        np.zeros((leaves, LANES), np.int64),
        np.zeros(leaves, np.int64),
        np.zeros((2 * leaves, 2, rows)),
        np.zeros((2 * leaves, 3), np.int64),
        np.zeros(2 * leaves),
        np.zeros(2, np.int64),
        np.zeros(DEEPEST, np.int64),
        np.zeros(DEEPEST),
        make_lanes(1),
    )


def widen_nodes(nodes: "Nodes", sizes: Sizes, count: int) -> "Nodes":
    """Return the same nodes with room for so many."""
    wider = make_nodes(count, sizes)
    size = int(nodes.size[0])
    for old, new in zip(nodes[:-1], wider[:-1], strict=True):
        new[:size] = old[:size]
    wider.size[:] = nodes.size
    return wider


def widen_poses(poses: "Poses", needles: int) -> "Poses":
    """Return the same poses with room for about twice as many."""
    wider = make_poses(2 * POSES_A_LEAF * len(poses.filled), needles)
    for old, new in zip(poses[:7], wider[:7], strict=True):
        new[: len(old)] = old
    return wider


def make_front(sizes: Sizes) -> "Front":
    """Return lanes without edges."""
    from nodes.kernels.crisp_lanes import LANES, make_lanes
    from nodes.kernels.crisp_tree_front import IDLE, Front

    needles = sizes.needles
    return Front(
        np.full(LANES, IDLE, np.int64),
        np.zeros(LANES, np.int64),
        np.zeros(LANES, np.int64),
        np.zeros(LANES, np.int64),
        np.zeros((LANES, needles, 4)),
        np.zeros((LANES, needles)),
        np.zeros((LANES, needles, 3)),
        np.zeros((LANES, needles)),
        make_lanes(6 * sizes.joints),
        make_lanes(9),
    )


def make_room(sizes: Sizes, seed: int) -> "Room":
    """Return where the kernels write as they go."""
    from nodes.kernels.crisp_lanes import LANES, make_lanes
    from nodes.kernels.crisp_straight_edges import Edges, Track
    from nodes.kernels.crisp_straight_residual import Pose
    from nodes.kernels.crisp_tree import Room
    from nodes.kernels.nearest_poses import ROWS
    from nodes.mechanics.crisp_lane_groups import make_room as make_solver

    needles, joints, pieces = sizes.needles, sizes.joints, sizes.pieces
    pose = Pose(make_lanes(6 * needles), make_lanes(needles), make_lanes(joints))
    edges = Edges(make_lanes(9 * needles), make_lanes(needles), make_lanes(joints), make_lanes(1))
    track, held = (
        Track(
            make_lanes(count, 6 * joints), make_lanes(count, 9), make_lanes(count, 1),
            make_lanes(2, 1),
        )
        for count in (sizes.chunk + 1, 1)
    )  # fmt: skip
    solver, work = make_solver(joints)
    tool, snares = 3 * (joints * pieces + 2), 3 * joints * (pieces + 1)
    return Room(
        pose, edges, track, held, np.empty(2 * joints, np.int64), solver, work,
        make_lanes(tool + snares), make_lanes(1),
        np.zeros(tool), np.zeros(snares), np.zeros((needles, 3)),
        *(np.zeros(LANES, np.int64) for _ in range(3)),
        np.zeros((needles, 4)), np.zeros(needles), np.zeros(ROWS * needles),
        np.array([seed], np.uint64), np.zeros(COUNTS, np.int64),
    )  # fmt: skip


def make_sights(cells: np.ndarray, field_of_view_deg: float) -> "Sights":
    """Return cells (cell, 3) of which none is seen yet."""
    from nodes.kernels.crisp_tree_views import Sights

    count = len(cells)
    return Sights(
        np.ascontiguousarray(cells, np.int64).reshape(count, 3),
        np.arange(count),
        np.array([count]),
        np.full(count, -1),
        half_view(field_of_view_deg),
        np.zeros(3),
        np.zeros(3),
    )
