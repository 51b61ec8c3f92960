"""Equilibria of CRISP robots, whatever bends them: snares, loads, pre-curved needles."""

import numpy as np
from jaxtyping import Float

from nodes.kernels.crisp_general_problem import Crisp, pack
from nodes.kernels.crisp_problem import Loads
from nodes.mechanics.crisp_arrays import to_grasps, to_loads, to_rods
from nodes.mechanics.crisp_solution import CrispSolution, RodState, unsolved
from nodes.mechanics.crisp_states import (
    bending_strain,
    measure_energy,
    measure_imbalance,
    sample,
    sample_rods,
)
from nodes.mechanics.parameters import ShapeCrispParameters
from nodes.mechanics.robots import CrispConfiguration, CrispSetup

PUSH = 3.0  # of E I / length^2, that bends a tool by about a radian
Wrenches = Float[np.ndarray, "n 6"]


def solve_crisp(
    setup: CrispSetup,
    configuration: CrispConfiguration,
    parameters: ShapeCrispParameters,
    seed: Wrenches | None = None,
) -> CrispSolution:
    """Return an equilibrium of one configuration.

    Parameters
    ----------
    setup, configuration : as `check_crisp_configuration` lets them pass.
    seed : (n, 6) base wrenches of a configuration near by, whose equilibrium is followed; without
        it, and where it leads nowhere, the stable equilibrium of least energy is sought.
    """
    if seed is not None:
        followed = _follow(setup, configuration, seed, parameters)
        if followed.status == "solved":
            return followed
    found = find_crisp_equilibria(setup, configuration, parameters)
    stable = [solution for solution in found if solution.status == "solved"]
    return (stable or found)[0]


def find_crisp_equilibria(
    setup: CrispSetup, configuration: CrispConfiguration, parameters: ShapeCrispParameters
) -> tuple[CrispSolution, ...]:
    """Return the equilibria that are found, least energy first.

    From rest, from random wrenches, and by letting go of random forces on the tool, which find what
    buckled. There may be more. Where none is found the one element says why.
    """
    from nodes.kernels.crisp_general_cold import close_gap, solve_from_rest
    from nodes.kernels.crisp_general_solve import NO_SOLUTION, SOLVED, new_newton

    crisp = to_crisp(setup, configuration)
    packed, tolerance = pack(crisp), parameters.tolerance_mm
    newton = new_newton(packed)
    seeds = _random_wrenches(crisp, parameters)
    first = np.zeros((len(crisp.lengths), 6))
    status, *_ = outcome = solve_from_rest(packed, first, seeds, tolerance, newton)
    if status == NO_SOLUTION:
        return (unsolved("no solution", _out_of_reach(), first),)
    tried = [(first, outcome)]
    for wrenches in seeds:
        tried.append((wrenches, close_gap(packed, wrenches, tolerance, newton)))
    for pushed in _pushed(crisp, parameters):
        wrenches = np.zeros_like(first)
        if solve_from_rest(pack(pushed), wrenches, seeds[:0], tolerance, newton)[0] == SOLVED:
            tried.append((wrenches, close_gap(packed, wrenches, tolerance, newton)))
    solved = [(wrenches, outcome) for wrenches, outcome in tried if outcome[0] == SOLVED]
    if not solved:
        return (unsolved("not converged", _lost(len(tried), outcome, tolerance), first),)
    apart = _distinct(crisp, solved, parameters.same_equilibrium)
    found = [_complete(setup, crisp, *one, parameters) for one in apart]
    return tuple(sorted(found, key=lambda solution: solution.energy_n_mm))


def to_crisp(setup: CrispSetup, configuration: CrispConfiguration) -> Crisp:
    """Return a configuration as kernels take it."""
    return Crisp(
        to_rods(setup),
        to_grasps(setup, float(configuration.lengths_mm[0])),
        to_loads(configuration),
        np.array(configuration.patient_from_entry, float),
        np.array(configuration.lengths_mm, float),
    )


def step_turn(crisp: Crisp, tolerance_mm: float) -> float:
    """Return how far a step of the integrator may turn for the tolerance, rad."""
    from nodes.kernels.crisp_general_solve import FINER, step_reach

    return FINER * step_reach(pack(crisp), tolerance_mm)


def _follow(
    setup: CrispSetup,
    configuration: CrispConfiguration,
    seed: Wrenches,
    parameters: ShapeCrispParameters,
) -> CrispSolution:
    from nodes.kernels.crisp_general_solve import NO_SOLUTION, SOLVED, new_newton, solve_wrenches

    crisp = to_crisp(setup, configuration)
    wrenches = np.array(seed, float)
    packed = pack(crisp)
    outcome = solve_wrenches(packed, wrenches, parameters.tolerance_mm, new_newton(packed))
    if outcome[0] == NO_SOLUTION:
        return unsolved("no solution", _out_of_reach(), wrenches)
    if outcome[0] != SOLVED:
        reason = _lost(1, outcome, parameters.tolerance_mm)
        return unsolved("not converged", reason, wrenches)
    return _complete(setup, crisp, wrenches, outcome, parameters)


def _complete(
    setup: CrispSetup,
    crisp: Crisp,
    wrenches: Wrenches,
    outcome: tuple[int, float, int, int],
    parameters: ShapeCrispParameters,
) -> CrispSolution:
    """Return all that follows from the base wrenches of an equilibrium."""
    reach = step_turn(crisp, parameters.tolerance_mm)
    rods = sample_rods(crisp, wrenches, parameters.sample_spacing_mm, reach)
    margin = _margin(crisp, wrenches, parameters)
    joints, joint_wrenches = _joints(crisp, wrenches, rods, reach)
    strains = [
        bending_strain(crisp, rod, state, needle.outer_diameter_mm / 2)
        for rod, (state, needle) in enumerate(zip(rods, setup.needles, strict=True))
    ]
    return CrispSolution(
        "solved" if margin > 0 else "unstable",
        "" if margin > 0 else _snaps(margin),
        wrenches,
        outcome[1],
        outcome[2],
        rods,
        _pose(rods[0], -1),
        joints,
        joint_wrenches,
        measure_energy(crisp, wrenches, reach),
        margin,
        np.array(strains),
        measure_imbalance(crisp, wrenches, reach),
    )


def _margin(crisp: Crisp, wrenches: Wrenches, parameters: ShapeCrispParameters) -> float:
    from nodes.kernels.crisp_stability import new_sturm, stability_margin

    packed = pack(crisp)
    accuracy = parameters.margin_accuracy
    return float(stability_margin(packed, wrenches, accuracy, new_sturm(packed)))


def _joints(
    crisp: Crisp, wrenches: Wrenches, rods: tuple[RodState, ...], reach: float
) -> tuple[Float[np.ndarray, "k 4 4"], Float[np.ndarray, "k 6"]]:
    """Return the tool's frames at the joints and the wrenches on the snares' tips."""
    if not len(crisp.grasps.arc):
        return np.empty((0, 4, 4)), np.empty((0, 6))
    at = sample(crisp, wrenches, 0, crisp.grasps.arc, reach)
    frames = np.array([_pose(at, joint) for joint in range(len(crisp.grasps.arc))])
    return frames, np.array([rods[rod].wrenches[-1] for rod in crisp.grasps.snare])


def _pose(state: RodState, index: int) -> Float[np.ndarray, "4 4"]:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = state.patient_from_body[index], state.points_patient_mm[index]
    return pose


def _random_wrenches(
    crisp: Crisp, parameters: ShapeCrispParameters
) -> Float[np.ndarray, "guess n 6"]:
    """Return wrenches that bend needles by about a radian, in any direction."""
    chance = np.random.default_rng(parameters.seed)
    moment = crisp.rods.bending / crisp.lengths
    units = np.stack([moment] * 3 + [moment / crisp.lengths] * 3, axis=1)
    return units * chance.normal(size=(parameters.guesses, *units.shape))


def _pushed(crisp: Crisp, parameters: ShapeCrispParameters) -> list[Crisp]:
    """Return the robot with a further random force on the tool, where all but its tail is."""
    chance = np.random.default_rng([parameters.seed, 1])
    acting = np.concatenate([crisp.grasps.arc, crisp.loads.arc])
    place = float(acting.max(initial=0.0)) or float(crisp.lengths[0])
    unit = PUSH * crisp.rods.bending[0] / place**2
    at = int(np.searchsorted(crisp.loads.arc, place))
    pushed = []
    for force in unit * chance.normal(size=(parameters.guesses, 3)):
        loads = Loads(
            np.insert(crisp.loads.arc, at, place),
            np.insert(crisp.loads.force, at, force, axis=0),
            np.insert(crisp.loads.moment, at, 0.0, axis=0),
        )
        pushed.append(crisp._replace(loads=loads))
    return pushed


def _distinct(
    crisp: Crisp, solved: list[tuple[Wrenches, tuple]], same: float
) -> list[tuple[Wrenches, tuple]]:
    """Return those whose base wrenches differ by more than `same` of a bend by a radian."""
    moment = crisp.rods.bending[0] / crisp.lengths[0]
    units = np.array([moment] * 3 + [moment / crisp.lengths[0]] * 3)
    kept: list[tuple[Wrenches, tuple]] = []
    for wrenches, outcome in solved:
        if all(np.abs((wrenches - other) / units).max() > same for other, _ in kept):
            kept.append((wrenches, outcome))
    return kept


def _out_of_reach() -> str:
    return (
        "no solution: two entry points lie farther apart than the needles between them are long;"
        " a needle is no shorter than the straight way to what it grasps"
    )


def _lost(guesses: int, outcome: tuple[int, float, int, int], tolerance: float) -> str:
    return (
        f"not converged: from {guesses} starts no equilibrium was found; {outcome[1]:.3g} mm are"
        f" left where {tolerance:g} are asked for, after {outcome[2]} evaluations of the"
        " derivatives, and three in a row did not halve them"
    )


def _snaps(margin: float) -> str:
    return (
        "unstable: an equilibrium that the robot would leave; its stability margin is"
        f" {margin:.4g}, and above 0 it stays"
    )
