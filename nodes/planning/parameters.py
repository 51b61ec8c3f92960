"""Parameters of planning, one class a node."""

from typing import Annotated, Literal

from pydantic import Field

from nodes.mechanics.parameters import FollowCrispEdgesParameters, ShapeCrispParameters
from nodes.parameters import Parameters

Grasp = Annotated[float, Field(gt=0, le=200)]


class ClearanceParameters(Parameters):
    """What counts as a touch; of all nodes of planning that check collisions."""

    margin_mm: Annotated[float, Field(ge=0, le=20)]
    """Least distance between needles and anatomy, mm."""
    sheath_mm: Annotated[float, Field(ge=0, le=100)]
    """How much of a needle from its entry point on may still touch the wall, since it lies in the
    stiff introducer sheath, mm."""
    outside_mm: Annotated[float, Field(ge=0, le=500)]
    """How far the sheath goes straight back from the entry point, mm."""
    grasp_mm: Annotated[float, Field(ge=0, le=100)]
    """How much of a snare before its tip may touch the tool that it grasps, mm."""
    sheath_avoids: tuple[Annotated[str, Field(min_length=1)], ...]
    """Names of the labels that sheaths keep margin_mm from outside of the cavity; none: they are
    not looked at."""
    piece_mm: Annotated[float, Field(gt=0, le=50)]
    """Longest chord that stands for a piece of a needle, mm; it is thickened by what the needle
    bends away from it."""
    coarsest_cell: Annotated[float, Field(gt=0)]
    """Largest cell of the occupancy grid, in outer radii of the thinnest needle: coarser cells are
    refused, since they do not show where it fits."""


class GrowCrispTreesParameters(ClearanceParameters):
    """How trees of configurations grow."""

    seed: Annotated[int, Field(ge=0)]
    """Of all that is drawn at random; without unit."""
    trees: Annotated[int, Field(ge=1, le=64)]
    """Trees that grow side by side from one start, each on a core; without unit."""
    node_limit: Annotated[int, Field(ge=1, le=50_000_000)]
    """Nodes of a set-up's trees together at which growing ends, the start counted; without unit."""
    time_limit_s: Annotated[float, Field(ge=0, le=86_400)]
    """Time after which the growing of one set-up's trees ends, s; 0 leaves the start alone."""
    stop_when_seen: bool
    """Whether growing ends as soon as all cells of the goals are seen, if there are any."""
    step_deg: Annotated[float, Field(gt=0, le=10)]
    """Largest turn of a needle between two configurations that are solved and tested, degrees."""
    step_mm: Annotated[float, Field(gt=0, le=10)]
    """Largest change of a needle's length between them, mm."""
    largest_strain: Annotated[float, Field(gt=0, le=1)]
    """How much needles may bend, as share of the strain from which their material comes back."""
    lever_mm: Annotated[float, Field(gt=0, le=1000)]
    """What a turn by a radian counts in the distance of two configurations, mm."""
    seed_from: Literal["parent", "start", "zero"]
    """From which wrenches a step is solved: those of the step before, those of the tree's start, or
    none [Kuntz2017] Sec. V-C."""
    joints_at_walls: Literal["all", "some"]
    """Which joints edges move that start where one failed at its first step: all, to the whole
    configuration that was drawn [Kuntz2017] Sec. IV-A, or some of them, drawn at random."""
    chunk_steps: Annotated[int, Field(ge=1, le=100)]
    """Steps of an edge that are solved before they are tested for touching; without unit."""
    tolerance_mm: Annotated[float, Field(gt=0, le=1e-3)]
    """What may be left of the joints' conditions, mm; see FollowCrispEdgesParameters."""
    integration_error_mm: Annotated[float, Field(gt=0, le=1e-3)]
    """Error of a needle's integrated shape at its end, mm."""
    largest_bend_rad: Annotated[float, Field(gt=0)]
    """Change of a needle's bend in one iteration, rad: more is shortened to it."""
    iterations: Annotated[int, Field(ge=2)]
    """Iterations at one step at most; without unit."""
    steps_between_checks: Annotated[int, Field(ge=1)]
    """Steps after which the integration's error is measured again; without unit."""
    refinements: Annotated[int, Field(ge=0)]
    """How often the way to the start's solution is cut finer; without unit."""


class GrowStudyTreesParameters(GrowCrispTreesParameters):
    """How trees grow that are compared at equal time."""

    compared_with: tuple[Literal["parent", "start", "zero"], ...]
    """Further ways to seed solves besides `seed_from`; each grows a tree of each set-up anew."""


class PlaceGoalsParameters(Parameters):
    """What the camera has to see."""

    snap_mm: Annotated[float, Field(ge=0, le=50)]
    """How far from the surface of the free space a marked point may lie, mm; it stands for the
    nearest cell."""
    goal_labels: tuple[Annotated[str, Field(min_length=1)], ...]
    """Names of painted regions: labels of the label map whose cells on the surface are goals."""
    random_goals: Annotated[int, Field(ge=0, le=1000)]
    """Places on the surface that are drawn at random as goals; without unit."""
    seed: Annotated[int, Field(ge=0)]
    """Seed of the random places; no unit."""


class SearchCrispSetupsParameters(GrowCrispTreesParameters):
    """Which set-ups are tried for a patient, and how they are compared.

    `node_limit` is that of the last round, in which the last candidates are compared.
    """

    material: Literal["nitinol", "stainless steel", "polycaprolactone"]
    """What needles are made of, with the constants of nodes/mechanics/materials.py."""
    inner_diameter_mm: Annotated[float, Field(ge=0, le=20)]
    """Of all needles, mm; 0 for wires."""
    outer_diameter_mm: Annotated[float, Field(gt=0, le=20)]
    """Of all needles, mm."""
    field_of_view_deg: Annotated[float, Field(gt=0, le=180)]
    """Full angle of the camera's cone, degrees."""
    joint: Literal["rigid", "relaxed"]
    """How the snare next to the tip holds the tool: [Kuntz2017] eq. (6), or [Anderson2017] eq. (6)
    and (16). Others are relaxed, since rigid joints hold all snares parallel."""
    grasp_places_mm: Annotated[tuple[Grasp, ...], Field(min_length=1)]
    """Places on the tool, from its tip, at which that snare is tried, mm."""
    joint_spacing_mm: Annotated[float, Field(gt=0, le=200)]
    """Least distance between joints along the tool, mm."""
    entry_spacing_mm: Annotated[float, Field(ge=0, le=300)]
    """Least distance between the entry points of a set-up, mm."""
    largest_tilt_deg: Annotated[float, Field(gt=0, le=90)]
    """How far a needle may turn from the direction in which its entry was found, degrees."""
    shortest_mm: Annotated[float, Field(ge=0, le=500)]
    """Least length of a needle beyond its entry point, mm."""
    longest_mm: Annotated[float, Field(gt=0, le=1000)]
    """Largest length of a needle beyond its entry point, mm."""
    directions: Annotated[int, Field(ge=1, le=10_000)]
    """Directions of the tool that are tried at each entry, evenly within its largest tilt."""
    two_needles: Annotated[int, Field(ge=0, le=1000)]
    """Set-ups of two needles that are grown in the first round; without unit."""
    three_needles: Annotated[int, Field(ge=0, le=1000)]
    """Set-ups of three needles that are grown in the first round; without unit."""
    rounds: Annotated[int, Field(ge=1, le=10)]
    """Rounds of growing; each has half the candidates of the one before, and twice the nodes."""
    setups: Annotated[int, Field(ge=1, le=20)]
    """Set-ups that are chosen: those that together see most; without unit."""
    for_goals: bool
    """Whether the goals count before the rest of the surface, where there are any."""
    farthest_start: Annotated[float, Field(gt=0, le=1000)]
    """How far from a start that does not work another is sought: the root of the sum of squares of
    all needles' turns, degrees, and changes of length, mm."""
    start_tries: Annotated[int, Field(ge=1, le=10_000)]
    """Starts that are tried at each distance from it; without unit."""


class CheckCrispPlansParameters(ShapeCrispParameters):
    """What a motion has to keep to be called a plan, and how finely that is looked at."""

    resolution: Annotated[int, Field(ge=1, le=1000)]
    """Configurations that are solved and looked at for each step of the motion."""
    margin_mm: Annotated[float, Field(ge=0, le=20)]
    """Least distance between needles and anatomy, and between sheaths and what they avoid, mm."""
    clear_mm: Annotated[float, Field(ge=0, le=20)]
    """Where a needle is this far from all anatomy first, it has left its introducer sheath, mm."""
    sheath_mm: Annotated[float, Field(ge=0, le=100)]
    """How much of a needle from its entry point on lies in its sheath at most, mm."""
    outside_mm: Annotated[float, Field(ge=0, le=500)]
    """How far the sheath goes straight back from the entry point, mm."""
    grasp_mm: Annotated[float, Field(ge=0, le=100)]
    """How much of a snare before its tip may touch the tool that it grasps, mm."""
    sheath_avoids: tuple[Annotated[str, Field(min_length=1)], ...]
    """Names of the labels that sheaths must not come near outside of the cavity."""
    accuracy_mm: Annotated[float, Field(gt=0, le=1)]
    """By how much the clearances that are told may be below the true ones along a needle, mm."""
    least_margin: Annotated[float, Field(ge=0, lt=1)]
    """Least stability margin, without unit: 1 is a free robot, at 0 it snaps to another shape."""
    agreement_mm: Annotated[float, Field(gt=0, le=1)]
    """How far the camera may be from where the planner says, mm; angles and wrenches count by what
    they move at the tool's tip."""
    largest_step_deg: Annotated[float, Field(gt=0, le=90)]
    """Largest turn of a needle from one step of the motion to the next, degrees."""
    largest_step_mm: Annotated[float, Field(gt=0, le=50)]
    """Largest change of a needle's length from one step of the motion to the next, mm."""
    snap_gain: Annotated[float, Field(ge=1, le=1000)]
    """The camera moves at most this many times as far as the joints, or the robot has snapped to
    another shape; turns count with the longest needle as lever."""
    seen_share: Annotated[float, Field(gt=0, le=1)]
    """Share of the cells said to be seen that are seen at least; rays that graze an edge differ by
    rounding."""


class PlanCrispMotionsParameters(FollowCrispEdgesParameters, ClearanceParameters):
    """How ways to goals are shortened, smoothed and cut."""

    viewpoints: Annotated[int, Field(ge=1, le=100)]
    """Plans to one goal at most, from whose ends together all is seen that any node sees of it."""
    candidates: Annotated[int, Field(ge=1, le=1000)]
    """Nodes that are tried for one viewpoint before it is given up; without unit."""
    reserve_mm: Annotated[float, Field(ge=0, le=5)]
    """What short cuts keep from anatomy at their steps beyond margin_mm, which holds between them,
    too, mm."""
    largest_strain: Annotated[float, Field(gt=0, le=1)]
    """How much short cuts may bend needles, as share of the strain from which their material comes
    back."""
    step_deg: Annotated[float, Field(gt=0, le=10)]
    """Largest turn of a needle between two configurations of a motion, degrees."""
    step_mm: Annotated[float, Field(gt=0, le=10)]
    """Largest change of a needle's length between them, mm."""
    lever_mm: Annotated[float, Field(gt=0, le=1000)]
    """What a turn by a radian counts in the length of a way, mm."""
    waypoints: Annotated[int, Field(ge=2, le=50)]
    """Places on a way between all of which short cuts are tried first; without unit."""
    rounds: Annotated[int, Field(ge=0, le=1000)]
    """Rounds of short cuts at random, and then of smaller and smaller ones about each corner."""
    tries: Annotated[int, Field(ge=1, le=1000)]
    """Short cuts tried in one round; without unit."""
    same_branch: Annotated[float, Field(gt=0, le=0.1)]
    """Wrenches that differ by less than this share of what bends the tool by a radian are those of
    one equilibrium; without unit."""
    finer: Annotated[int, Field(ge=1, le=100)]
    """Into how many parts each step of a motion is cut to verify it; without unit."""
    seed: Annotated[int, Field(ge=0)]
    """Of the short cuts at random; without unit."""
