"""Tables of set-ups, tried or handed in."""

from typing import TYPE_CHECKING

import numpy as np

from nodes.planning.artefacts import PlacedSetup
from nodes.planning.crisp_collisions import check_steps
from nodes.planning.parameters import SearchCrispSetupsParameters
from nodes.planning.setup_candidates import Place
from nodes.planning.setup_judging import Scene, solve_starts
from nodes.planning.setup_rounds import Grown
from nodes.planning.tree_start import follow_parameters

if TYPE_CHECKING:
    import pandas

LARGEST_MM, FINE_MM = 20.0, 0.05  # clearances that are told: up to the one, as finely as the other


def tabulate_grown(
    grown: list[Grown], count: int, place: Place, parameters: SearchCrispSetupsParameters
) -> "pandas.DataFrame":
    """Return one row a candidate, the first `count` of which are chosen."""
    import pandas

    scene = Scene(place.cavity, place.wall, parameters, follow_parameters(parameters))
    rows = [
        _describe(one.candidate.placed, rank, rank <= count, scene)
        | {"share_unbent": one.candidate.unbent_share}
        | {
            f"share_round_{number + 1}": one.shares[number] if number < len(one.shares) else np.nan
            for number in range(parameters.rounds)
        }
        | {"goals_seen": one.goals, "nodes": one.nodes}
        for rank, one in enumerate(grown, start=1)
    ]
    return pandas.DataFrame(rows)


def tabulate_given(setups: tuple[PlacedSetup, ...], scene: Scene) -> "pandas.DataFrame":
    """Return one row a set-up."""
    import pandas

    return pandas.DataFrame(
        [_describe(placed, rank, True, scene) for rank, placed in enumerate(setups, start=1)]
    )


def _describe(placed: PlacedSetup, rank: int, chosen: bool, scene: Scene) -> dict[str, object]:
    snares = sorted(placed.setup.snares, key=lambda snare: snare.needle)
    return {
        "name": placed.name,
        "chosen": chosen,
        "rank": rank,
        "needles": len(placed.setup.needles),
        "entries": ", ".join(str(number) for number in placed.entries),
        "grasps_mm": ", ".join(f"{snare.grasp_mm:.1f}" for snare in snares),
        "clearance_mm": find_clearance(placed, scene),
    }


def find_clearance(placed: PlacedSetup, scene: Scene) -> float:
    """Return the largest margin with which the start touches nothing, up to a limit, mm."""
    start, setup = placed.start, placed.setup
    frames, lengths = start.patient_from_entry[None], start.lengths_mm[None]
    _, wrenches = solve_starts(setup, frames, lengths, scene.solving)
    low, high = scene.clearances.margin_mm, LARGEST_MM
    while high - low > FINE_MM:
        middle = (low + high) / 2
        wider = scene.clearances.model_copy(update={"margin_mm": middle})
        free = check_steps(setup, frames, lengths, wrenches, wider, scene.cavity, scene.wall) == 0
        low, high = (middle, high) if free[0] else (low, middle)
    return low
