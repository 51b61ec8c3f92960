"""Equilibria of CRISP robots, whatever bends them: snares, loads, pre-curved needles."""

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.kernels.crisp_general_problem import Crisp, pack
from nodes.kernels.crisp_problem import Loads
from nodes.mechanics.crisp_arrays import to_grasps, to_loads, to_rods
from nodes.mechanics.crisp_modes import unstable_modes
from nodes.mechanics.crisp_reasons import Outcome, say_lost, say_out_of_reach, say_unstable
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
DEPTH = 3  # how often what an unstable equilibrium goes over to is left again, and once
Wrenches = Float[np.ndarray, "n 6"]


def solve_crisp(
    setup: CrispSetup,
    configuration: CrispConfiguration,
    parameters: ShapeCrispParameters,
    seed: Wrenches | None = None,
) -> CrispSolution:
    """Return an equilibrium of one configuration.

    Without a seed the stable one of least energy that is found; "unstable" only where no stable one
    is found. With a seed the one that continues its branch and no other: where that is lost the
    answer is "not converged", and where it cannot last "unstable"; what else there is a call
    without a seed finds.

    Parameters
    ----------
    setup, configuration : as `check_crisp_configuration` lets them pass.
    seed : (n, 6) base wrenches of a configuration near by, whose equilibrium is followed.
    """
    if seed is not None:
        if seed.shape != (len(setup.needles), 6) or not np.isfinite(seed).all():
            raise BadInput(
                f"a seed of shape {seed.shape}",
                f"{len(setup.needles)} needles have finite base wrenches of shape"
                f" {(len(setup.needles), 6)}",
                "give the base wrenches of a solution near by",
            )
        return _follow(setup, configuration, seed, parameters)
    found = find_crisp_equilibria(setup, configuration, parameters)
    stable = [solution for solution in found if solution.status == "solved"]
    return (stable or found)[0]


def find_crisp_equilibria(
    setup: CrispSetup, configuration: CrispConfiguration, parameters: ShapeCrispParameters
) -> tuple[CrispSolution, ...]:
    """Return the equilibria that are found, least energy first.

    From rest, from random wrenches, by letting go of random forces on the tool, which find what
    buckled, and by leaving each unstable one the way it gives. There may be more. Where none is
    found the one element says why.
    """
    from nodes.kernels.crisp_general_solve import NO_SOLUTION, SOLVED

    crisp = to_crisp(setup, configuration)
    tried = _search(crisp, parameters)
    wrenches, outcome = tried[0]
    if outcome[0] == NO_SOLUTION:
        return (unsolved("no solution", say_out_of_reach(), wrenches),)
    found: list[CrispSolution] = []
    for _ in range(DEPTH):
        fresh = []
        for wrenches, outcome in tried:
            if outcome[0] == SOLVED and _is_new(crisp, wrenches, found, parameters):
                found.append(_complete(setup, crisp, wrenches, outcome, parameters))
                fresh.append(found[-1])
        tried = [one for solution in fresh for one in _leave(crisp, solution, parameters)]
    if not found:
        return (unsolved("not converged", say_lost(outcome, parameters.tolerance_mm), wrenches),)
    return tuple(sorted(found, key=lambda solution: solution.energy_n_mm))


def _search(crisp: Crisp, parameters: ShapeCrispParameters) -> list[tuple[Wrenches, Outcome]]:
    """Return what all starts lead to, the first that from rest."""
    from nodes.kernels.crisp_general_cold import close_gap, solve_from_rest
    from nodes.kernels.crisp_general_solve import NO_SOLUTION, new_newton

    packed, tolerance = pack(crisp), parameters.tolerance_mm
    newton = new_newton(packed)
    seeds = _random_wrenches(crisp, parameters)
    first = np.zeros((len(crisp.lengths), 6))
    tried = [(first, solve_from_rest(packed, first, seeds, tolerance, newton))]
    if tried[0][1][0] == NO_SOLUTION:
        return tried
    for wrenches in seeds:
        tried.append((wrenches, close_gap(packed, wrenches, tolerance, newton)))
    chance = np.random.default_rng([parameters.seed, 1])
    for direction in chance.normal(size=(parameters.guesses, 3)):
        tried += _release(crisp, _push(crisp)[1] * direction, parameters)
    return tried


def _leave(
    crisp: Crisp, solution: CrispSolution, parameters: ShapeCrispParameters
) -> list[tuple[Wrenches, Outcome]]:
    """Return what an unstable equilibrium goes over to, either way: it is pushed in the direction
    in which it gives."""
    # A robot that is free to turn, with a margin of 0 but for rounding, has no way to prefer.
    if not -np.inf < solution.stability_margin < -10 * parameters.margin_accuracy:
        return []
    reach = step_turn(crisp, parameters.tolerance_mm)
    modes = unstable_modes(crisp, solution.base_wrenches, solution.stability_margin, reach)
    arc, unit = _push(crisp)
    place = sample(crisp, solution.base_wrenches, 0, np.array([arc]), reach).points_patient_mm[0]
    tried = []
    for moment in modes[:, 0, :3]:
        force = np.cross(moment, place - crisp.rods.entry[0])
        size = np.linalg.norm(force)
        if size > 0:
            tried += _release(crisp, unit * force / size, parameters)
            tried += _release(crisp, -unit * force / size, parameters)
    return tried


def _release(
    crisp: Crisp, force: Float[np.ndarray, "3"], parameters: ShapeCrispParameters
) -> list[tuple[Wrenches, Outcome]]:
    """Return where the robot goes when a further force on the tool is let go, if it could bear
    it."""
    from nodes.kernels.crisp_general_cold import close_gap, solve_from_rest
    from nodes.kernels.crisp_general_solve import SOLVED, new_newton

    tolerance, wrenches = parameters.tolerance_mm, np.zeros((len(crisp.lengths), 6))
    packed = pack(crisp)
    newton = new_newton(packed)
    pushed = pack(crisp._replace(loads=_with_force(crisp, force)))
    outcome = solve_from_rest(pushed, wrenches, np.empty((0, *wrenches.shape)), tolerance, newton)
    if outcome[0] != SOLVED:
        return []
    return [(wrenches, close_gap(packed, wrenches, tolerance, newton))]


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
    from nodes.kernels.crisp_general_solve import FINER
    from nodes.kernels.crisp_general_units import step_reach

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
        return unsolved("no solution", say_out_of_reach(), wrenches)
    if outcome[0] != SOLVED:
        reason = (
            say_lost(outcome, parameters.tolerance_mm) + ": the seed's branch does not lead here"
        )
        return unsolved("not converged", reason, np.array(seed, float))
    return _complete(setup, crisp, wrenches, outcome, parameters)


def _complete(
    setup: CrispSetup,
    crisp: Crisp,
    wrenches: Wrenches,
    outcome: Outcome,
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
        "solved" if margin > parameters.margin_accuracy else "unstable",
        "" if margin > parameters.margin_accuracy else say_unstable(margin),
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


def _push(crisp: Crisp) -> tuple[float, float]:
    """Return the place on the tool where all but its tail is, mm, and a force there, N, that bends
    it by about a radian."""
    acting = np.concatenate([crisp.grasps.arc, crisp.loads.arc])
    place = float(acting.max(initial=0.0)) or float(crisp.lengths[0])
    return place, PUSH * crisp.rods.bending[0] / place**2


def _with_force(crisp: Crisp, force: Float[np.ndarray, "3"]) -> Loads:
    """Return the loads and a further force, where `_push` says."""
    place = _push(crisp)[0]
    at = int(np.searchsorted(crisp.loads.arc, place))
    return Loads(
        np.insert(crisp.loads.arc, at, place),
        np.insert(crisp.loads.force, at, force, axis=0),
        np.insert(crisp.loads.moment, at, 0.0, axis=0),
    )


def _is_new(
    crisp: Crisp,
    wrenches: Wrenches,
    found: list[CrispSolution],
    parameters: ShapeCrispParameters,
) -> bool:
    """Return whether base wrenches differ from all that were found."""
    moment = crisp.rods.bending[0] / crisp.lengths[0]
    units = np.array([moment] * 3 + [moment / crisp.lengths[0]] * 3)
    return all(
        np.abs((wrenches - other.base_wrenches) / units).max() > parameters.same_equilibrium
        for other in found
    )
