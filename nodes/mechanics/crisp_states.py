"""What follows from the base wrenches of an equilibrium: shape, energy, strain, balance."""

from itertools import pairwise

import numpy as np
from jaxtyping import Float

from nodes.kernels.crisp_general_problem import Crisp, pack
from nodes.kernels.crisp_problem import Grasps, Loads
from nodes.mechanics.crisp_solution import RodState

NODES = 12  # of Gauss, in a stretch that turns by at most TURN: the energy is right to rounding
TURN = 1.0  # rad
Wrenches = Float[np.ndarray, "n 6"]


def sample_rods(
    crisp: Crisp, wrenches: Wrenches, spacing_mm: float, reach: float
) -> tuple[RodState, ...]:
    """Return all needles at most `spacing_mm` apart, with the places where something acts."""
    rods = []
    for rod, length in enumerate(crisp.lengths):
        ends = _ends(crisp, rod)
        arcs = [np.linspace(0.0, length, int(np.ceil(length / spacing_mm)) + 1), ends]
        rods.append(sample(crisp, wrenches, rod, np.unique(np.concatenate(arcs)), reach))
    return tuple(rods)


def sample(
    crisp: Crisp, wrenches: Wrenches, rod: int, arcs: Float[np.ndarray, "q"], reach: float
) -> RodState:
    """Return one needle at increasing arc lengths, mm from its entry point."""
    from nodes.kernels.crisp_general_sample import sample_rod

    found = np.empty((len(arcs), 18))
    # Copies, since kernels are compiled once more for arrays that are read-only.
    sample_rod(pack(crisp), np.array(wrenches), rod, np.array(arcs), reach, found)
    axes = found[:, 3:12].reshape(-1, 3, 3).transpose(0, 2, 1)
    return RodState(arcs, found[:, :3], axes, found[:, 12:])


def elastic_moments(crisp: Crisp, rod: int, state: RodState) -> Float[np.ndarray, "q 3"]:
    """Return the moments in the needle's own axes: two that bend and one that twists, N mm."""
    return np.einsum("qij,qi->qj", state.patient_from_body, state.wrenches[:, :3])


def measure_energy(crisp: Crisp, wrenches: Wrenches, reach: float) -> float:
    """Return elastic energy less the work of the loads' forces, N mm.

    A moment that keeps its world axis does no work that a place alone could tell; it is left out.
    """
    total = 0.0
    for rod in range(len(crisp.lengths)):
        arcs, weights = _quadrature(crisp, wrenches, rod)
        state = sample(crisp, wrenches, rod, arcs, reach)
        moments = elastic_moments(crisp, rod, state)
        bending, torsion = crisp.rods.bending[rod], crisp.rods.torsion[rod]
        density = (moments**2 / [bending, bending, torsion]).sum(axis=1) / 2
        total += float(weights @ density)
    if len(crisp.loads.arc):
        places = load_places(crisp, wrenches, reach)
        total -= float(np.sum(places * crisp.loads.force))
    return total


def load_places(crisp: Crisp, wrenches: Wrenches, reach: float) -> Float[np.ndarray, "l 3"]:
    """Return where the loads pull."""
    return sample(crisp, wrenches, 0, crisp.loads.arc, reach).points_patient_mm


def measure_imbalance(crisp: Crisp, wrenches: Wrenches, reach: float) -> Float[np.ndarray, "6"]:
    """Return moment about the origin and force that entry points and loads leave; 0 at rest.

    What the entry points hold is known without integrating, so this tests all of the shape.
    """
    loads, left = crisp.loads, np.zeros(6)
    left[3:] = loads.force.sum(axis=0) - wrenches[:, 3:].sum(axis=0)
    left[:3] = loads.moment.sum(axis=0) - wrenches[:, :3].sum(axis=0)
    left[:3] -= np.cross(crisp.rods.entry, wrenches[:, 3:]).sum(axis=0)
    if len(loads.arc):
        left[:3] += np.cross(load_places(crisp, wrenches, reach), loads.force).sum(axis=0)
    return left


def bending_strain(crisp: Crisp, rod: int, state: RodState, radius_mm: float) -> float:
    """Return the largest strain of bending away from the needle's own shape, at its surface."""
    moments = elastic_moments(crisp, rod, state)[:, :2]
    return float(np.linalg.norm(moments, axis=1).max() / crisp.rods.bending[rod] * radius_mm)


def _ends(crisp: Crisp, rod: int) -> Float[np.ndarray, "q"]:
    """Return where a needle's pieces end."""
    length = float(crisp.lengths[rod])
    acting = _acting(crisp.grasps, crisp.loads) if rod == 0 else np.empty(0)
    return np.unique(np.concatenate([[0.0], acting, [length]]))


def _acting(grasps: Grasps, loads: Loads) -> Float[np.ndarray, "q"]:
    return np.concatenate([grasps.arc, loads.arc])


def _quadrature(
    crisp: Crisp, wrenches: Wrenches, rod: int
) -> tuple[Float[np.ndarray, "q"], Float[np.ndarray, "q"]]:
    """Return Gauss nodes and weights of all pieces of a needle."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    stiffness = crisp.rods.bending[rod]
    force = np.linalg.norm(wrenches[:, 3:], axis=1).sum() / stiffness
    moment = np.linalg.norm(wrenches[rod, :3]) / stiffness + force * crisp.lengths[rod]
    rate = moment + np.sqrt(force) + np.linalg.norm(crisp.rods.precurvature[rod])
    places, shares = [], []
    ends = _ends(crisp, rod)
    for start, end in pairwise(ends):
        cuts = np.linspace(start, end, min(int(rate * (end - start) / TURN), 100) + 2)
        half = np.diff(cuts)[:, None] / 2
        places.append((cuts[:-1, None] + half * (1 + nodes)).ravel())
        shares.append((half * weights).ravel())
    return np.concatenate(places), np.concatenate(shares)
