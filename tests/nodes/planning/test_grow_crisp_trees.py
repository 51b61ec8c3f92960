"""Trees in a small ellipsoid: valid edges, limits, seeds; touches are found by brute force."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial.transform import Rotation

from catalog.yaml_file import load_mapping
from nodes.environment.measure_distance import measure_distance
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.lines_of_sight import find_surface, look_anew
from nodes.geometry.origin import Origin
from nodes.mechanics.crisp_edges import SOLVED, CrispEdges
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Material, Needle, Snare
from nodes.mechanics.sample_crisp_needles import sample_crisp_needles
from nodes.planning.artefacts import Goals, PlacedSetup, PlacedSetups
from nodes.planning.grow_crisp_trees import grow_crisp_trees
from nodes.planning.parameters import GrowCrispTreesParameters
from nodes.planning.tree_start import follow_parameters
from tests.nodes.mechanics.made_crisp_edges import PARAMETERS as EXACT

ROOT = Path(__file__).resolve().parents[3]
DEFAULTS = load_mapping(ROOT / "catalog/parameters/grow_crisp_trees.yml")
HERE = Origin("test", simulated=True)
HALF_AXES = np.array([50.0, 30.0, 24.0])
CELL = 2.0
TOOL_ENTRY, SNARE_ENTRY = np.array([-36.0, 0.0, 17.0]), np.array([4.0, -2.0, 24.0])
MIDDLE = np.array([14.0, 0.0, -3.0])
RADIUS = 0.51


def cavity():
    """An ellipsoid about the patient's origin, and the distances from its wall."""
    shape = np.ceil(2 * HALF_AXES / CELL).astype(int) + 4
    patient_from_index = np.diag([CELL, CELL, CELL, 1.0])
    patient_from_index[:3, 3] = -CELL * (shape - 1) / 2
    places = np.moveaxis(np.indices(shape), 0, -1) * CELL + patient_from_index[:3, 3]
    free = ((places / HALF_AXES) ** 2).sum(axis=-1) < 1
    boundary = ndimage.binary_dilation(free) & ~free
    voxels = free.astype(np.uint8) + 2 * boundary.astype(np.uint8)
    grid = LabelMap(voxels, patient_from_index, ("free", "boundary"), HERE)
    return grid, measure_distance(grid)


GRID, FIELD = cavity()
BONE = LabelMap(np.zeros_like(GRID.voxels), GRID.patient_from_index, ("bone",), HERE)


def unit(vector):
    return vector / np.linalg.norm(vector)


def placed(joint="rigid"):
    """An unbent start: the snare meets the tool at a right angle, before its tip."""
    t = unit(MIDDLE - TOOL_ENTRY)
    foot = (SNARE_ENTRY - TOOL_ENTRY) @ t
    u = unit(TOOL_ENTRY + foot * t - SNARE_ENTRY)
    reach = np.linalg.norm(TOOL_ENTRY + foot * t - SNARE_ENTRY)
    x = np.cross(t, u)
    frames = np.stack([np.stack([x, -u, t], axis=1), np.stack([x, t, u], axis=1)])
    metal = Material("nitinol", 50000.0, 0.33, 0.08)
    needles = (Needle(metal, 0.84, 2 * RADIUS, np.zeros(3)),) * 2
    entries = np.stack([TOOL_ENTRY, SNARE_ENTRY])
    setup = CrispSetup(needles, entries, (Snare(1, 10.0, "tip", joint),), 90.0, HERE)
    start = CrispConfiguration(frames, np.array([foot + 10.0, reach]))
    axes = np.stack([t, u])
    limits = np.array([15.0, 15.0]), np.array([90.0, 60.0])
    return PlacedSetup("made", setup, start, axes, np.radians([35.0, 35.0]), *limits)


def parameters(**changed):
    values = DEFAULTS | {
        "sheath_avoids": (), "coarsest_cell": 4.0, "node_limit": 150, "time_limit_s": 3600.0,
        "sheath_mm": 8.0,
    }  # fmt: skip
    return GrowCrispTreesParameters(**(values | changed))


def goals(*cells):
    cells = np.array(cells, int).reshape(-1, 3)
    points = np.zeros((len(cells), 3))
    names = tuple(f"goal {place}" for place in range(len(cells)))
    return Goals(names, cells, np.arange(len(cells)), points, HERE)


def grow(of=None, seen=(), **changed):
    setups = PlacedSetups((of or placed(),), HERE)
    return grow_crisp_trees(setups, GRID, FIELD, BONE, goals(*seen), parameters(**changed)).trees[0]


@pytest.fixture(scope="module")
def tree():
    return grow()


def frames_of(tree):
    turns = Rotation.from_quat(tree.quaternions.reshape(-1, 4), scalar_first=True)
    return turns.as_matrix().reshape(*tree.quaternions.shape[:2], 3, 3)


def edges_of(tree):
    frames, later = frames_of(tree), np.arange(1, len(tree.parents))
    before = tree.parents[later]
    return CrispEdges(
        frames[before], frames[later], tree.lengths_mm[before], tree.lengths_mm[later],
        tree.wrenches[before], tree.steps[later],
    )  # fmt: skip


def replay(tree):
    return follow_crisp_edges(tree.placed.setup, edges_of(tree), EXACT)


def box_distances(points):
    """Distance of points to the nearest box of a cell that is not free, looking at all within two
    cells; beyond those, at least one and a half cells."""
    is_free = np.pad(GRID.mask("free"), 4)
    index = (points - GRID.patient_from_index[:3, 3]) / CELL
    nearest = np.full(len(points), 1.5 * CELL)
    middle = np.round(index).astype(int)
    for shift in np.ndindex(5, 5, 5):
        cell = middle + np.array(shift) - 2
        apart = np.maximum(np.abs(index - cell) - 0.5, 0) * CELL
        taken = ~is_free[tuple((cell + 4).T)]
        distance = np.linalg.norm(apart, axis=1)
        nearest = np.where(taken, np.minimum(nearest, distance), nearest)
    return nearest


def test_every_step_of_every_edge_is_solved_on_the_branch_of_its_parent(tree):
    track, steps = replay(tree), tree.steps[1:]
    for edge, count in enumerate(steps):
        assert (track.status[edge, : count + 1] == SOLVED).all()
    edges = np.arange(len(steps))
    cameras = track.patient_from_camera[edges, steps]
    assert np.abs(cameras[:, :3, 3] - tree.cameras_patient_mm[1:]).max() < 0.01
    assert np.abs(cameras[:, :3, 2] - tree.views[1:]).max() < 1e-3
    wrenches = track.wrenches[edges, steps]
    assert np.abs(wrenches - tree.wrenches[1:]).max() < 1e-3 * np.abs(wrenches).max()


def test_needles_keep_their_margin_on_every_step_of_every_edge(tree):
    edges, track, asked = edges_of(tree), replay(tree), parameters()
    places, lengths, wrenches = [], [], []
    for edge, count in enumerate(tree.steps[1:]):
        share = np.linspace(0, 1, count + 1)
        turns = (edges.ends[edge] @ edges.starts[edge].swapaxes(-1, -2)).reshape(-1, 3, 3)
        vectors = Rotation.from_matrix(turns).as_rotvec()
        turned = Rotation.from_rotvec((share[:, None, None] * vectors).reshape(-1, 3)).as_matrix()
        places.append(turned.reshape(count + 1, -1, 3, 3) @ edges.starts[edge])
        growths = edges.end_lengths_mm[edge] - edges.start_lengths_mm[edge]
        lengths.append(edges.start_lengths_mm[edge] + share[:, None] * growths)
        wrenches.append(track.wrenches[edge, : count + 1])
    robots = np.concatenate(places), np.concatenate(lengths), np.concatenate(wrenches)
    points = sample_crisp_needles(tree.placed.setup, *robots, 40)
    entries = tree.placed.setup.entry_points_patient_mm
    needles = points.tool_patient_mm, points.snares_patient_mm[:, 0]
    for entry, needle in zip(entries, needles, strict=True):
        is_out = np.linalg.norm(needle - entry, axis=2) > asked.sheath_mm
        assert box_distances(needle[is_out]).min() > RADIUS + asked.margin_mm - 0.01
    assert len(robots[1]) > 500


def test_needles_keep_their_limits_everywhere_on_every_edge(tree):
    of = placed()  # almost at the limit from the start, from where many geodesics go beyond it
    aside = Rotation.from_rotvec(np.radians(11.9) * of.start.patient_from_entry[:, :, 0])
    tight = replace(of, axes=aside.apply(of.axes.copy()), largest_tilts_rad=np.radians([12, 12]))
    cut = grow(of=tight, node_limit=60)
    assert {one.name: one.value for one in cut.counts}["tilts too far"] > 0
    for one in (tree, cut):
        of, edges = one.placed, edges_of(one)
        turns = (edges.ends @ edges.starts.swapaxes(-1, -2)).reshape(-1, 3, 3)
        vectors = Rotation.from_matrix(turns).as_rotvec()
        for share in np.linspace(0, 1, 101):
            now = Rotation.from_rotvec(share * vectors).as_matrix().reshape(edges.starts.shape)
            tangents = (now @ edges.starts)[..., 2]
            across = np.linalg.norm(np.cross(tangents, of.axes), axis=-1)
            tilts = np.arctan2(across, (tangents * of.axes).sum(axis=-1))
            assert (tilts <= of.largest_tilts_rad + 1e-9).all()
        assert (one.lengths_mm >= of.shortest_mm - 1e-9).all()
        assert (one.lengths_mm <= of.longest_mm + 1e-9).all()
        assert np.abs(np.linalg.norm(one.quaternions, axis=2) - 1).max() < 1e-12


@pytest.mark.parametrize("limit", [20, 21])
def test_trees_of_unequal_sizes_tell_the_first_node_that_sees_a_cell(limit):
    cells = np.argwhere(GRID.mask("boundary"))[::50]
    tree, surface = grow(seen=cells, node_limit=limit), find_surface(GRID)
    sizes = np.bincount(tree.trees[1:], minlength=2)
    assert sizes.sum() == limit - 1 and np.ptp(sizes) == (limit - 1) % 2
    seen = look_anew(surface, tree.cameras_patient_mm, tree.views, 90.0)
    numbers = surface.numbers[tuple(cells.T)]
    first = np.where(seen.any(axis=0), seen.argmax(axis=0), -1)[numbers]
    assert np.array_equal(tree.seeing, first) and (first >= 0).any()


def test_only_edges_from_walls_leave_joints_where_they_are(tree):
    whole = grow(joints_at_walls="all")
    assert not np.isclose(whole.lengths_mm[1:], whole.lengths_mm[whole.parents[1:]]).any()
    assert np.isclose(tree.lengths_mm[1:], tree.lengths_mm[tree.parents[1:]]).any()


def test_steps_are_no_larger_than_asked(tree):
    edges, asked = edges_of(tree), parameters()
    turns = (edges.ends @ edges.starts.swapaxes(-1, -2)).reshape(-1, 3, 3)
    angles = np.degrees(Rotation.from_matrix(turns).magnitude()).reshape(len(edges.steps), -1)
    assert (angles.max(axis=1) <= asked.step_deg * edges.steps + 1e-6).all()
    growths = np.abs(edges.end_lengths_mm - edges.start_lengths_mm).max(axis=1)
    assert (growths <= asked.step_mm * edges.steps + 1e-9).all()


def test_parents_come_before_their_children_and_time_goes_on(tree):
    assert tree.parents[0] == -1 and tree.steps[0] == 0 and tree.seconds[0] == 0
    assert (tree.parents[1:] < np.arange(1, len(tree.parents))).all()
    assert (tree.parents[1:] >= 0).all() and (tree.steps[1:] >= 1).all()
    for side in (0, 1):
        assert (np.diff(tree.seconds[tree.trees == side]) >= 0).all()
        own = np.flatnonzero(tree.trees == side)
        assert np.isin(tree.parents[own[own > 0]], np.append(own, 0)).all()


def test_same_seed_gives_the_same_tree_to_the_last_bit(tree):
    again = grow()
    for name in ("parents", "quaternions", "lengths_mm", "wrenches", "steps", "trees"):
        assert np.array_equal(getattr(tree, name), getattr(again, name)), name
    assert [one.value for one in again.counts] == [one.value for one in tree.counts]
    assert not np.array_equal(grow(seed=1).lengths_mm, tree.lengths_mm)


def test_a_tree_does_not_depend_on_those_beside_it(tree):
    own = np.flatnonzero(tree.trees == 0)
    alone = grow(trees=1, node_limit=len(own))
    assert np.array_equal(alone.quaternions, tree.quaternions[own])
    assert np.array_equal(alone.wrenches, tree.wrenches[own])
    assert np.array_equal(own[alone.parents[1:]], tree.parents[own[1:]])


@pytest.mark.parametrize("limit", [1, 2, 3, 40])
def test_as_many_nodes_as_asked_for(limit):
    tree = grow(node_limit=limit)
    assert len(tree.parents) == limit and tree.ending == "node limit"


def test_no_time_leaves_the_start_alone():
    tree = grow(time_limit_s=0.0)
    assert len(tree.parents) == 1 and tree.ending == "time limit"
    start = tree.placed.start.patient_from_entry
    assert np.abs(frames_of(tree)[0] - start).max() < 1e-12
    assert tree.wrenches.shape == (1, 2, 6) and np.abs(tree.wrenches).max() < 1e-3


def test_time_limit_is_kept_to_50_ms():
    tree = grow(time_limit_s=0.3, node_limit=10_000_000)
    assert tree.ending == "time limit" and len(tree.parents) > 10
    assert 0.25 < tree.seconds.max() < 0.35


def test_growing_ends_when_all_goals_are_seen_by_the_nodes_that_are_told():
    boundary = np.argwhere(GRID.mask("boundary"))
    far = boundary[[boundary[:, 0].argmax(), len(boundary) // 3]]
    tree = grow(seen=far, stop_when_seen=True, node_limit=20_000)
    assert tree.ending == "goals seen" and len(tree.parents) < 20_000
    points = far * CELL + GRID.patient_from_index[:3, 3]
    for point, node in zip(points, tree.seeing, strict=True):
        way = unit(point - tree.cameras_patient_mm[node])
        assert way @ tree.views[node] >= np.cos(np.radians(45)) - 1e-4
    again = grow(seen=far, stop_when_seen=True, node_limit=20_000)
    assert np.array_equal(again.lengths_mm, tree.lengths_mm)
    assert [one.value for one in again.counts] == [one.value for one in tree.counts]


@pytest.mark.parametrize("seed_from", ["start", "zero"])
def test_steps_solved_from_afar_end_at_the_same_equilibria(seed_from):
    tree = grow(seed_from=seed_from, node_limit=40)
    track = follow_crisp_edges(tree.placed.setup, edges_of(tree), follow_parameters(parameters()))
    ends = track.patient_from_camera[np.arange(39), tree.steps[1:], :3, 3]
    agree = np.abs(ends - tree.cameras_patient_mm[1:]).max(axis=1) < 0.05
    assert agree.mean() > 0.7  # others went over to another branch, which seeding is there for


def test_start_that_touches_is_refused():
    with pytest.raises(BadInput, match="anatomy"):
        grow(margin_mm=15.0)


def test_relaxed_joints_grow_too():
    tree = grow(of=placed("relaxed"), node_limit=30)
    assert len(tree.parents) == 30
    steps = tree.steps[1:]
    status = replay(tree).status
    assert all((status[edge, : count + 1] == SOLVED).all() for edge, count in enumerate(steps))
