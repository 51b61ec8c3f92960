"""Motions of CRISP robots to where their cameras see goals."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.lines_of_sight import SurfaceCells, find_surface
from nodes.geometry.origin import Origin
from nodes.mechanics.shapes import Figure
from nodes.planning.artefacts import (
    CrispMotion,
    CrispTree,
    CrispTrees,
    Goals,
    MotionPlan,
    MotionPlans,
)
from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.parameters import PlanCrispMotionsParameters
from nodes.planning.plan_edges import Ground
from nodes.planning.plan_paths import trace_back
from nodes.planning.plan_views import (
    Offer,
    collect_offers,
    find_next,
    find_seen,
    restrict,
)
from nodes.planning.plan_ways import Way, plan_way
from nodes.planning.reach_goals import prove_unreachable


class Scene(NamedTuple):
    """All that plans are made from."""

    trees: tuple[CrispTree, ...]
    grounds: tuple[Ground, ...]
    surface: SurfaceCells
    occupancy_grid: LabelMap
    distance_field: Volume
    parameters: PlanCrispMotionsParameters


def plan_crisp_motions(
    crisp_trees: CrispTrees,
    occupancy_grid: LabelMap,
    distance_field: Volume,
    label_map: LabelMap,
    goals: Goals,
    parameters: PlanCrispMotionsParameters,
) -> MotionPlans:
    """Return for each goal motions to where the camera sees it, or why there are none.

    The way from a tree's start to a node that sees the goal [Kuntz2017] Sec. IV-A is shortened by
    geodesics that are valid, its corners are cut off, and it is cut into even steps; then it is
    verified at finer ones. A region is seen from several nodes: of these, greedily, those are
    chosen that together see most of it. Whether a motion may be called a plan says the check after
    this one.
    """
    cavity, wall = (
        make_cavity(occupancy_grid, distance_field),
        make_wall(label_map, parameters.sheath_avoids),
    )
    grounds = tuple(Ground(tree.placed, cavity, wall, parameters) for tree in crisp_trees.trees)
    scene = Scene(
        crisp_trees.trees, grounds, find_surface(occupancy_grid),
        occupancy_grid, distance_field, parameters,
    )  # fmt: skip
    origin = crisp_trees.origin.with_notice(*goals.origin.notices)
    if not crisp_trees.trees:
        return MotionPlans((), origin.with_notice("no set-up to plan motions with"))
    plans = [plan for goal in range(len(goals.names)) for plan in _plan_goal(scene, goals, goal)]
    source = f"motions to {goals.origin.source}, shortened, from {origin.source}"
    return MotionPlans(tuple(plans), Origin(source, origin.simulated, origin.notices))


def _plan_goal(scene: Scene, goals: Goals, goal: int) -> list[MotionPlan]:
    """Return the plans to one goal, each with cells that none before it shows."""
    chosen = goals.goals == goal
    cells = goals.cells[chosen]
    surface = restrict(scene.surface, cells)
    offers = collect_offers(surface, scene.trees, chosen)
    if not offers:
        return [_tell_unseen(scene, goals, goal, cells)]
    left = np.any([offer.seen for offer in offers], axis=0)
    rng = np.random.default_rng([scene.parameters.seed, goal])
    found, failed = [], [0] * len(scene.trees)
    while left.any() and len(found) < scene.parameters.viewpoints:
        tried_out = [count == scene.parameters.candidates for count in failed]
        offers = [one for one in offers if not tried_out[one.tree]]
        offer = _choose(scene, offers, left)
        if offer is None:
            break
        offers = [one for one in offers if one is not offer]
        way, seen = _try_offer(scene, surface, offer, left, rng)
        if way is None:
            failed[offer.tree] += 1
            later = find_next(surface, scene.trees, offer)
            offers += [later] if later else []
            continue
        found.append((offer, way, seen))
        left &= ~seen
        failed = [0] * len(scene.trees)
    if not found:
        return [_tell_failed(scene, goals, goal, sum(failed))]
    return [_to_plan(scene, goals, goal, cells, found, number) for number in range(len(found))]


def _choose(scene: Scene, offers: list[Offer], left: Bool[np.ndarray, "cell"]) -> Offer | None:
    """Return the node that sees most of what is left; of several, the one fewest edges away."""
    counts = [int(np.count_nonzero(offer.seen & left)) for offer in offers]
    most = max(counts, default=0)
    if most == 0:
        return None
    best = [offer for offer, count in zip(offers, counts, strict=True) if count == most]
    return min(best, key=lambda o: (len(trace_back(scene.trees[o.tree].parents, o.node)), o[:2]))


def _try_offer(
    scene: Scene,
    surface: SurfaceCells,
    offer: Offer,
    left: Bool[np.ndarray, "cell"],
    rng: np.random.Generator,
) -> tuple[Way | None, Bool[np.ndarray, "cell"]]:
    """Return a motion to where all is seen that a node sees of what is left, and what it sees."""
    ground, tree = scene.grounds[offer.tree], scene.trees[offer.tree]
    angle = tree.placed.setup.field_of_view_deg
    wanted = restrict(surface, surface.cells[offer.seen & left])

    def sees_it(pose: np.ndarray) -> bool:
        return bool(find_seen(wanted, pose[:3, 3], pose[:3, 2], angle).all())

    way = plan_way(ground, tree, offer.node, sees_it, rng)
    if way is None:
        return None, np.zeros_like(left)
    pose = way.motion.patient_from_camera[-1]
    return way, find_seen(surface, pose[:3, 3], pose[:3, 2], angle)


def _to_plan(
    scene: Scene,
    goals: Goals,
    goal: int,
    cells: Int[np.ndarray, "cell 3"],
    found: list[tuple[Offer, Way, Bool[np.ndarray, "cell"]]],
    number: int,
) -> MotionPlan:
    offer, way, seen = found[number]
    name = goals.names[goal] + (f" {number + 1}/{len(found)}" if len(found) > 1 else "")
    lever = scene.parameters.lever_mm
    length = f"length of the way; a turn by a radian counts as {lever:g} mm"
    figures = (
        Figure("way found", way.found_mm, "mm", f"{length}, as the tree found it"),
        Figure("way planned", way.length_mm, "mm", f"{length}, after it was shortened"),
        Figure("steps", len(way.motion.lengths_mm) - 1.0, "", "steps of the motion"),
    )
    tree = scene.trees[offer.tree]
    point = goals.points_patient_mm[goal]
    return MotionPlan(name, point, cells[seen], tree.placed, "planned", "", way.motion, figures)


def _tell_unseen(
    scene: Scene, goals: Goals, goal: int, cells: Int[np.ndarray, "cell 3"]
) -> MotionPlan:
    """Return why no node sees a goal: proven for all set-ups, or only not found."""
    proofs = [
        prove_unreachable(
            tree.placed, tree.cameras_patient_mm[0],
            scene.occupancy_grid, scene.distance_field, cells, scene.parameters,
        )
        for tree in scene.trees
    ]  # fmt: skip
    if all(proofs):
        reasons = [
            f"{tree.placed.name}: {proof}" for tree, proof in zip(scene.trees, proofs, strict=True)
        ]
        return _no_motion(scene, goals, goal, "unreachable", "; ".join(reasons))
    return _no_motion(scene, goals, goal, "not seen", f"{_tell_tried(scene)} sees it")


def _tell_failed(scene: Scene, goals: Goals, goal: int, failed: int) -> MotionPlan:
    reason = (
        f"{_tell_tried(scene)} offers a motion that stays valid between the tree's steps; {failed}"
        " that see it were tried"
    )
    return _no_motion(scene, goals, goal, "not seen", reason)


def _tell_tried(scene: Scene) -> str:
    nodes = sum(len(tree.parents) for tree in scene.trees)
    seconds = sum(float(tree.seconds[-1]) for tree in scene.trees)
    of = "one set-up" if len(scene.trees) == 1 else f"{len(scene.trees)} set-ups"
    return f"none of the {nodes} configurations that {of} reached in {seconds:.3g} s"


def _no_motion(scene: Scene, goals: Goals, goal: int, status: str, reason: str) -> MotionPlan:
    placed = scene.trees[0].placed
    needles = len(placed.setup.needles)
    nothing = CrispMotion(
        np.zeros((0, needles, 3, 3)),
        np.zeros((0, needles)),
        np.zeros((0, needles, 6)),
        np.zeros((0, 4, 4)),
    )
    point, none = goals.points_patient_mm[goal], np.zeros((0, 3), int)
    return MotionPlan(goals.names[goal], point, none, placed, status, reason, nothing, ())
