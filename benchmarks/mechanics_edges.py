"""Edges of CRISP robots between random configurations, and how exactly they are followed."""

import numpy as np

from benchmarks.mechanics_cases import offset_configuration
from nodes.mechanics.crisp_edges import CrispEdges, CrispTracks
from nodes.mechanics.parameters import FollowCrispEdgesParameters, ShapeCrispParameters
from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.mechanics.solve_crisp import solve_crisp, to_crisp
from tests.nodes.mechanics import oracle_crisp
from tests.nodes.mechanics.oracle_crisp_rods import robot_of

# What the benchmark times: 1e-6 mm at the tip, and nothing sought besides the one equilibrium.
FOLLOW = FollowCrispEdgesParameters(
    tolerance_mm=1e-6,
    integration_error_mm=1e-7,
    largest_bend_rad=0.5,
    iterations=20,
    steps_between_checks=5,
    refinements=3,
)
SHAPE = ShapeCrispParameters(
    tolerance_mm=1e-6,
    sample_spacing_mm=5.0,
    guesses=0,
    seed=0,
    same_equilibrium=1e-5,
    margin_accuracy=1e-6,
)


def random_targets(
    chance: np.random.Generator, needles: int, count: int, room: tuple[float, float] = (8.0, 4.0)
) -> np.ndarray:
    """Return (count, needle, 4) offsets from a first configuration, degrees and mm."""
    limits = np.array([room[0] / np.sqrt(3)] * 3 + [room[1]])
    return chance.uniform(-1, 1, (count, needles, 4)) * limits


def edges_between(
    first: CrispConfiguration, starts: np.ndarray, ends: np.ndarray, steps: int | None = None
) -> CrispEdges:
    """Return edges between offsets from a first configuration, in steps of 1 mm and 1 degree at
    most unless their number is given; all starts are yet to be solved."""
    ways = ends - starts
    largest = np.maximum(np.linalg.norm(ways[..., :3], axis=2), np.abs(ways[..., 3])).max(1)
    counts = np.ceil(largest).astype(int) if steps is None else np.full(len(ways), steps)
    begin = [offset_configuration(first, offset) for offset in starts]
    end = [offset_configuration(first, offset) for offset in ends]
    return CrispEdges(
        np.array([one.patient_from_entry for one in begin]),
        np.array([one.patient_from_entry for one in end]),
        np.array([one.lengths_mm for one in begin]),
        np.array([one.lengths_mm for one in end]),
        np.zeros((len(ways), len(first.lengths_mm), 6)),
        counts,
    )


def ends_of(edges: CrispEdges, tracks: CrispTracks) -> np.ndarray:
    """Return the wrenches (edge, needle, 6) at the edges' ends, nan where they were not reached."""
    return tracks.wrenches[np.arange(len(edges.steps)), edges.steps]


def edge_error(setup, first, ends, edges, tracks, count: int = 5) -> float:
    """Return the largest distance of the camera at edges' ends from the oracle's, mm."""
    worst, found = 0.0, ends_of(edges, tracks)
    for edge in np.flatnonzero(~np.isnan(found).any((1, 2)))[:count]:
        robot = robot_of(setup, offset_configuration(first, ends[edge]))
        slow = oracle_crisp.polish(robot, found[edge])
        camera = tracks.patient_from_camera[edge, edges.steps[edge]]
        worst = max(worst, float(np.abs(camera[:3, 3] - slow.tip_point).max()))
    return worst


def near_by(
    setup: CrispSetup, first: CrispConfiguration, count: int
) -> tuple[CrispSetup, list[CrispConfiguration], np.ndarray]:
    """Return configurations 1 mm and 1 degree around a first one, and its base wrenches."""
    offsets = random_targets(np.random.default_rng(3), len(first.lengths_mm), count, (1.0, 1.0))
    parent = solve_crisp(setup, first, SHAPE).base_wrenches
    return setup, [offset_configuration(first, offset) for offset in offsets], parent


def solve_near(setup, ways, parent) -> tuple[np.ndarray, np.ndarray]:
    """Solve configurations on the general path from their parent's wrenches; return (n, 4) status,
    residual and evaluations, and the wrenches."""
    from nodes.kernels.crisp_general_batch import solve_many
    from nodes.kernels.crisp_general_problem import pack

    lengths = np.array([way.lengths_mm for way in ways])
    frames = np.array([way.patient_from_entry for way in ways])
    crisp = to_crisp(setup, ways[0])
    arcs = lengths[:, :1] - (lengths[0, 0] - crisp.grasps.arc)  # snares hold the tool's material
    found, wrenches = np.empty((len(ways), 4)), np.repeat(parent[None], len(ways), 0)
    solve_many(pack(crisp), frames, lengths, arcs, wrenches, FOLLOW.tolerance_mm, False, found)
    return found, wrenches
