"""Equilibria of a CRISP robot along a motion, each found from the one before it.

By the general path, which takes whatever bends the needles; loads are left out.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays
from nodes.kernels.crisp_general_problem import pack
from nodes.mechanics.crisp_reach import find_grasps
from nodes.mechanics.crisp_reasons import say_lost, say_out_of_reach, say_unstable
from nodes.mechanics.parameters import ShapeCrispParameters
from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.mechanics.solve_crisp import to_crisp


@dataclass(frozen=True)
class CrispChain:
    """The stable equilibria from the first configuration on.

    Parameters
    ----------
    wrenches : (c, needle, 6) moment, N mm, and force, N, at the entry points.
    margins : (c,) stability margins, without unit.
    lost : why the next configuration has none; empty where all are solved.
    """

    wrenches: Float[np.ndarray, "c needle 6"]
    margins: Float[np.ndarray, "c"]
    lost: str

    def __post_init__(self) -> None:
        freeze_arrays(self)


def solve_crisp_batch(
    setup: CrispSetup,
    orientations: Float[np.ndarray, "b needle 3 3"],
    lengths_mm: Float[np.ndarray, "b needle"],
    seed: Float[np.ndarray, "needle 6"],
    parameters: ShapeCrispParameters,
) -> CrispChain:
    """Solve configurations that follow one another closely.

    Parameters
    ----------
    orientations : patient_from_entry of each needle.
    seed : wrenches near those of the first configuration.
    """
    from nodes.kernels.crisp_general_chain import follow_chain
    from nodes.kernels.crisp_general_solve import NO_SOLUTION, UNSTABLE

    wrenches, found = np.zeros((*lengths_mm.shape, 6)), np.zeros((len(lengths_mm), 4))
    wrenches[0] = seed
    count = follow_chain(
        *_pack(setup, orientations, lengths_mm), wrenches, parameters.tolerance_mm,
        parameters.margin_accuracy, found,
    )  # fmt: skip
    lost = ""
    if count < len(found):
        status, residual, evaluations, margin = found[count]
        outcome = (int(status), float(residual), int(evaluations), 0)
        lost = say_lost(outcome, parameters.tolerance_mm)
        if status == NO_SOLUTION:
            lost = say_out_of_reach()
        if status == UNSTABLE:
            lost = say_unstable(float(margin))
    return CrispChain(wrenches[:count], found[:count, 3], lost)


def sample_crisp_batch(
    setup: CrispSetup,
    orientations: Float[np.ndarray, "b needle 3 3"],
    lengths_mm: Float[np.ndarray, "b needle"],
    wrenches: Float[np.ndarray, "b needle 6"],
    places_mm: tuple[Float[np.ndarray, "b _"], ...],
    tolerance_mm: float,
) -> list[Float[np.ndarray, "b _ 18"]]:
    """Return of each needle places, axes d1, d2, d3, moment and force along it, patient axes.

    Parameters
    ----------
    wrenches : of solutions.
    places_mm : of each needle increasing distances from its entry point, mm.
    """
    from nodes.kernels.crisp_general_chain import sample_chain

    robot, states = _pack(setup, orientations, lengths_mm), []
    for needle, places in enumerate(places_mm):
        states.append(np.empty((*places.shape, 18)))
        sample_chain(*robot, np.array(wrenches), needle, np.array(places), tolerance_mm, states[-1])
    return states


def _pack(setup: CrispSetup, orientations: np.ndarray, lengths_mm: np.ndarray) -> tuple:
    """Return the robot and its joint values as kernels take them; copies, for kernels are compiled
    once more for arrays that are read-only."""
    crisp = pack(to_crisp(setup, CrispConfiguration(orientations[0], lengths_mm[0])))
    arcs = np.ascontiguousarray(find_grasps(setup, lengths_mm))
    return crisp, np.array(orientations), np.array(lengths_mm), arcs
