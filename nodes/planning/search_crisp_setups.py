"""Which set-ups of a CRISP robot a patient gets: those handed in, or those that see most."""

from dataclasses import replace
from typing import TYPE_CHECKING

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.lines_of_sight import find_surface
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import Goals, PlacedSetup, PlacedSetups
from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.check_entries import check_entries
from nodes.planning.check_starts import check_kind, check_start
from nodes.planning.crisp_collisions import refuse_coarse_cells
from nodes.planning.parameters import SearchCrispSetupsParameters
from nodes.planning.setup_candidates import Candidate, Place, find_candidates
from nodes.planning.setup_judging import Scene
from nodes.planning.setup_nearest import Search
from nodes.planning.setup_rounds import grow_in_rounds
from nodes.planning.setup_starts import read_entries
from nodes.planning.setup_tables import tabulate_given, tabulate_grown
from nodes.planning.tree_start import follow_parameters

if TYPE_CHECKING:
    import pandas

    from nodes.kernels.crisp_collision import Space

CHOSEN = "set-ups are chosen by growing trees for a limited number of nodes from unbent starts"


def search_crisp_setups(
    given_setups: PlacedSetups,
    entry_table: "pandas.DataFrame",
    label_map: LabelMap,
    occupancy_grid: LabelMap,
    distance_field: Volume,
    goals: Goals,
    parameters: SearchCrispSetupsParameters,
) -> tuple[PlacedSetups, "pandas.DataFrame"]:
    """Check the set-ups that a person handed in, or choose some for the patient.

    All pairs of entries for a tool and a snare are held against the anatomy at starts in which no
    needle is bent. Those of which the unbent starts together see most become candidates; some get a
    second snare. Trees of candidates are grown in rounds, the half that together sees most goes on
    to twice the nodes, and those are chosen that together see most of the surface, or of the goals.
    Nothing depends on the clock: a machine that is slow takes longer.

    Parameters
    ----------
    given_setups : what a person chose; if there is any, nothing is searched.
    entry_table : whose rows for the part "free" are tried.
    label_map, occupancy_grid, distance_field : the anatomy and the space in it.
    goals : that count first, where `for_goals` says so.

    Returns
    -------
    placed_setups : the best first.
    setup_table : one row a set-up that was grown or handed in: `name`, `chosen`, `rank`, `needles`,
        `entries` (numbers in the table of entries, the tool's first), `grasps_mm` from the tool's
        tip, `clearance_mm` (of the start, to anatomy and of sheaths to bone; up to a limit),
        `share_unbent` (of the surface, seen from unbent starts of its tool and first snare),
        `share_round_1`, ... (seen after each round), `goals_seen`, `nodes` of its last tree.

    Raises
    ------
    BadInput where a set-up that was handed in cannot be planned with, or none can be made of the
    entries.
    """
    cavity = make_cavity(occupancy_grid, distance_field)
    wall = make_wall(label_map, parameters.sheath_avoids)
    if given_setups.setups:
        return _take_given(given_setups, label_map, occupancy_grid, (cavity, wall), parameters)
    if not parameters.two_needles + parameters.three_needles:
        raise BadInput(
            "two_needles: 0 and three_needles: 0",
            "a search grows set-ups of two needles or of three",
            "set one of the two above 0, or hand in set-ups as given_setups",
        )
    needles = 2 if parameters.two_needles else 3
    place = Place(
        read_entries(entry_table, needles), find_surface(occupancy_grid), cavity, wall, goals
    )
    candidates = find_candidates(place, parameters)
    if not candidates:
        raise _no_start(len(place.entries.numbers), parameters)
    notice = refuse_coarse_cells(occupancy_grid, candidates[0].placed.setup, parameters)
    grown = grow_in_rounds(candidates, place, parameters)
    count = min(parameters.setups, len(grown))
    grown = [
        one._replace(candidate=_rename(one.candidate, f"setup {rank}")) if rank <= count else one
        for rank, one in enumerate(grown, start=1)
    ]
    origin = Origin(
        f"a search over entries into {occupancy_grid.origin.source}",
        simulated=True,
        notices=occupancy_grid.origin.notices,
    ).with_notice(CHOSEN, *filter(None, [notice]))
    setups = tuple(_call(one.candidate.placed, origin) for one in grown[:count])
    return PlacedSetups(setups, origin), tabulate_grown(grown, count, place, parameters)


def _take_given(
    given: PlacedSetups,
    label_map: LabelMap,
    occupancy_grid: LabelMap,
    spaces: tuple["Space", "Space"],
    parameters: SearchCrispSetupsParameters,
) -> tuple[PlacedSetups, "pandas.DataFrame"]:
    """Check what was handed in, and return it."""
    scene = Scene(*spaces, parameters, follow_parameters(parameters))
    search = Search(parameters.farthest_start, parameters.start_tries, parameters.seed)
    notices = []
    for placed in given.setups:
        check_kind(placed)
        check_entries(
            placed, label_map, occupancy_grid, parameters.sheath_avoids, parameters.sheath_mm
        )
        notices.append(refuse_coarse_cells(occupancy_grid, placed.setup, parameters))
        check_start(placed, scene, search)
    origin = given.origin.with_notice(*filter(None, notices))
    return PlacedSetups(given.setups, origin), tabulate_given(given.setups, scene)


def _call(placed: PlacedSetup, origin: Origin) -> PlacedSetup:
    """Return the set-up with what it comes from in its own file, too."""
    return replace(placed, setup=replace(placed.setup, origin=origin))


def _rename(candidate: Candidate, name: str) -> Candidate:
    placed: PlacedSetup = replace(candidate.placed, name=name)
    return candidate._replace(placed=placed)


def _no_start(entries: int, parameters: SearchCrispSetupsParameters) -> BadInput:
    return BadInput(
        f"{entries} entries, and no two of them at least {parameters.entry_spacing_mm:g} mm apart"
        " from which straight needles meet at right angles without touching anything",
        f"a search begins with straight needles that keep {parameters.margin_mm:g} mm from anatomy,"
        f" tilted by at most {parameters.largest_tilt_deg:g} degrees,"
        f" {parameters.shortest_mm:g} to {parameters.longest_mm:g} mm long",
        "raise directions or largest_tilt_deg, lower entry_spacing_mm or margin_mm, list more"
        " entries (candidate_spacing_mm of find_entry_corridors), or hand in set-ups",
    )
