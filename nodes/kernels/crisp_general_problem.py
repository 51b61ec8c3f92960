"""A CRISP robot in one configuration, as the kernels of the general path take it."""

from typing import NamedTuple

import numpy as np

from nodes.kernels.crisp_problem import Grasps, Loads, Rods


class Crisp(NamedTuple):
    """rotations : (n, 3, 3) world from body at the bases; lengths : (n,) mm."""

    rods: Rods
    grasps: Grasps
    loads: Loads
    rotations: np.ndarray
    lengths: np.ndarray


class Packed(NamedTuple):
    """The same in few arrays: each more in a kernel's arguments makes it slower to compile.

    soft : (n, 5) 1 / EI, 1 / GJ - 1 / EI, pre-curvature of each rod.
    bases : (n, 13) entry point, the body's axes d1, d2, d3 there, length; see LENGTH.
    joints : (k, 4) along the tool; see ARC to COSINE.
    loads : (l, 7) along the tool: arc, moment, force.
    """

    soft: np.ndarray
    bases: np.ndarray
    joints: np.ndarray
    loads: np.ndarray


LENGTH = 12
ARC, SNARE, RIGID, COSINE = 0, 1, 2, 3


def pack(crisp: Crisp) -> Packed:
    """Return a robot in the arrays that kernels hand on."""
    rods, grasps, loads = crisp.rods, crisp.grasps, crisp.loads
    bending = 1 / rods.bending
    axes = np.swapaxes(crisp.rotations, 1, 2).reshape(-1, 9)
    return Packed(
        np.column_stack([bending, 1 / rods.torsion - bending, rods.precurvature]),
        np.column_stack([rods.entry, axes, crisp.lengths]),
        np.column_stack([grasps.arc, grasps.snare, grasps.rigid, grasps.cosine]),
        np.column_stack([loads.arc, loads.moment, loads.force]),
    )
