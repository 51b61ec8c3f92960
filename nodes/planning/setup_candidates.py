"""Set-ups that are worth growing: those whose unbent starts see most."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Float

from nodes.geometry.lines_of_sight import SurfaceCells
from nodes.mechanics.materials import MATERIALS
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, Snare
from nodes.planning.artefacts import Goals, PlacedSetup
from nodes.planning.crisp_collisions import check_steps
from nodes.planning.parameters import SearchCrispSetupsParameters
from nodes.planning.setup_scores import find_columns, score_pairs, thin_surface
from nodes.planning.setup_starts import (
    Entries,
    Limits,
    Starts,
    check_starts,
    lay_starts,
    roll_needles,
    spread_tangents,
)

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Space


class Candidate(NamedTuple):
    """A set-up with an unbent start.

    unbent_share : of the surface that the unbent starts of its tool and first snare see together.
    """

    placed: PlacedSetup
    unbent_share: float


class Place(NamedTuple):
    """Where set-ups are sought."""

    entries: Entries
    surface: SurfaceCells
    cavity: "Space"
    wall: "Space"
    goals: Goals


class Straight(NamedTuple):
    """A tool and a snare with the start that was chosen.

    start : one row.
    share, counted : of the surface, and of the cells that count, seen from all its unbent starts.
    """

    start: Starts
    grasp_mm: float
    share: float
    counted: float


def find_candidates(place: Place, parameters: SearchCrispSetupsParameters) -> list[Candidate]:
    """Return set-ups of two needles, then of three: those whose tool and first snare see most from
    unbent starts."""
    straight = _find_straight(place, parameters)
    if not straight:
        return []
    tools = np.array([int(one.start.tools[0]) for one in straight])
    _, firsts = np.unique(tools, return_index=True)
    # Each tool's entry once, so that cameras differ; then those that are left.
    is_again = ~np.isin(np.arange(len(tools)), firsts)
    order = np.argsort(is_again, kind="stable")[: parameters.two_needles]
    pairs = [
        Candidate(_place(place.entries, straight[number], parameters), straight[number].share)
        for number in order
    ]
    triples: list[Candidate] = []
    for one in straight:
        if len(triples) == parameters.three_needles:
            break
        third = _add_snare(place, one, parameters)
        if third is not None:
            triples.append(Candidate(third, one.share))
    return pairs + triples


def _find_straight(place: Place, parameters: SearchCrispSetupsParameters) -> list[Straight]:
    """Return all pairs of entries and grasps with a free unbent start, most seeing ones first."""
    from nodes.kernels.crisp_collision import Rules

    radius = parameters.outer_diameter_mm / 2
    rules = Rules(
        np.full(2, radius), parameters.margin_mm, parameters.sheath_mm, parameters.grasp_mm,
        parameters.outside_mm,
    )  # fmt: skip
    tilt = float(np.radians(parameters.largest_tilt_deg))
    limits = Limits(
        tilt, parameters.shortest_mm, parameters.longest_mm, parameters.entry_spacing_mm
    )
    tangents = spread_tangents(place.entries.axes, tilt, parameters.directions)
    surface = thin_surface(place.surface, place.goals.cells)
    columns = find_columns(surface, place.goals, parameters.for_goals)
    found = []
    for grasp in parameters.grasp_places_mm:
        starts = lay_starts(place.entries, tangents, grasp, limits)
        codes = check_starts(place.entries, starts, grasp, rules, place.cavity, place.wall)
        free = starts.take(codes == 0)
        pairs = score_pairs(place.entries, free, grasp, parameters.field_of_view_deg, surface)
        found += [
            Straight(
                free.take(np.array([best])), grasp, float(seen.mean()), float(seen[columns].mean())
            )
            for best, seen in zip(pairs.best, pairs.seen, strict=True)
        ]
    return sorted(found, key=lambda one: (-one.counted, -one.share))


def _place(entries: Entries, one: Straight, parameters: SearchCrispSetupsParameters) -> PlacedSetup:
    """Return the set-up of a tool and a snare."""
    tool, other = roll_needles(one.start.tangents, one.start.snare_tangents)
    return _put_together(
        entries,
        np.array([one.start.tools[0], one.start.snares[0]]),
        np.concatenate([tool, other]),
        np.array([one.start.feet_mm[0] + one.grasp_mm, one.start.reaches_mm[0]]),
        (Snare(1, one.grasp_mm, "tip", parameters.joint),),
        parameters,
    )


def _put_together(
    entries: Entries,
    rows: np.ndarray,
    frames: Float[np.ndarray, "needle 3 3"],
    lengths: Float[np.ndarray, "needle"],
    snares: tuple[Snare, ...],
    parameters: SearchCrispSetupsParameters,
) -> PlacedSetup:
    inner, outer = parameters.inner_diameter_mm, parameters.outer_diameter_mm
    needle = Needle(MATERIALS[parameters.material], inner, outer, np.zeros(3))
    needles = (needle,) * len(rows)
    numbers = tuple(int(number) for number in entries.numbers[rows])
    setup = CrispSetup(needles, entries.points[rows], snares, parameters.field_of_view_deg)
    return PlacedSetup(
        "entries " + ", ".join(str(number) for number in numbers),
        setup,
        CrispConfiguration(frames, lengths),
        entries.axes[rows],
        np.full(len(rows), np.radians(parameters.largest_tilt_deg)),
        _shortest(snares, parameters.shortest_mm),
        np.full(len(rows), parameters.longest_mm),
        numbers,
    )


def _shortest(snares: tuple[Snare, ...], shortest_mm: float) -> Float[np.ndarray, "needle"]:
    """Return each needle's least length; all grasps stay so far beyond the tool's entry point."""
    return shortest_mm + np.array([max(snare.grasp_mm for snare in snares), *(0.0 for _ in snares)])


def _add_snare(
    place: Place, one: Straight, parameters: SearchCrispSetupsParameters
) -> PlacedSetup | None:
    """Return a pair with a second snare, straight too and held relaxed, nearer to the tool's entry:
    of the free ones that whose joint is farthest from the first; None if none is free."""
    entries, start = place.entries, one.start
    tool, first, tangent = int(start.tools[0]), int(start.snares[0]), start.tangents[0]
    ways = entries.points - entries.points[tool]
    feet = ways @ tangent
    across = feet[:, None] * tangent - ways
    reaches = np.linalg.norm(across, axis=1)
    sides = across / np.maximum(reaches, np.finfo(float).tiny)[:, None]
    apart = np.minimum(
        np.linalg.norm(ways, axis=1),
        np.linalg.norm(entries.points - entries.points[first], axis=1),
    )
    tilted = np.einsum("na,na->n", sides, entries.axes)
    fits = (apart >= parameters.entry_spacing_mm) & (feet >= parameters.shortest_mm)
    fits &= feet <= start.feet_mm[0] - parameters.joint_spacing_mm
    fits &= tilted >= np.cos(np.radians(parameters.largest_tilt_deg))
    fits &= (reaches >= parameters.shortest_mm) & (reaches <= parameters.longest_mm)
    pair = _place(entries, one, parameters)
    tool_length = float(pair.start.lengths_mm[0])
    for row in sorted(np.flatnonzero(fits), key=lambda row: feet[row]):
        _, frame = roll_needles(tangent[None], sides[row][None])
        placed = _put_together(
            entries,
            np.array([tool, first, row]),
            np.concatenate([pair.start.patient_from_entry, frame]),
            np.append(pair.start.lengths_mm, reaches[row]),
            (*pair.setup.snares, Snare(2, tool_length - float(feet[row]), "tip", "relaxed")),
            parameters,
        )
        if _is_free(placed, place, parameters):
            return placed
    return None


def _is_free(placed: PlacedSetup, place: Place, parameters: SearchCrispSetupsParameters) -> bool:
    """Return whether an unbent start touches nothing."""
    start = placed.start
    frames, lengths = start.patient_from_entry[None], start.lengths_mm[None]
    nothing = np.zeros((1, len(start.lengths_mm), 6))
    codes = check_steps(
        placed.setup, frames, lengths, nothing, parameters, place.cavity, place.wall
    )
    return int(codes[0]) == 0
