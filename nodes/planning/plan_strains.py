"""How much the needles of solved CRISP robots are strained."""

import numpy as np
from jaxtyping import Float, Int

from nodes.mechanics.robots import CrispSetup
from nodes.mechanics.sample_crisp_needles import NeedlePoints

Points = Float[np.ndarray, "robot point 3"]
Vectors = Float[np.ndarray, "robot 3"]


def find_strains(
    setup: CrispSetup,
    points: NeedlePoints,
    wrenches: Float[np.ndarray, "robot needle 6"],
    order: Int[np.ndarray, "needle"],
) -> Float[np.ndarray, "robot"]:
    """Return the largest strain at any needle's surface, as share of what its material comes back
    from.

    Between joints m + p x n is constant, and a straight needle is curved by what of the moment m is
    across it, over E I [Anderson2017] eq. (1)-(5); the strain is that times the outer radius.

    Parameters
    ----------
    points : along the needles.
    wrenches : moment, N mm, and force, N, at the entry points.
    order : the needles in the order of the points, the tool first.
    """
    entries = setup.entry_points_patient_mm
    snares = order[1:]
    pieces = points.snares_patient_mm.shape[2] - 1
    forces = wrenches[:, snares, 3:]
    about = wrenches[:, snares, :3] + np.cross(entries[snares], forces)  # about the frame's origin
    worst = np.zeros(len(wrenches))
    for joint, needle in enumerate(snares):
        rods = (
            (needle, points.snares_patient_mm[:, joint], about[:, joint], forces[:, joint]),
            (
                0,
                points.tool_patient_mm[:, joint * pieces : (joint + 1) * pieces + 1],
                -about[:, joint:].sum(axis=1),
                -forces[:, joint:].sum(axis=1),
            ),
        )
        for number, places, moments, held in rods:
            tube = setup.needles[number]
            most = tube.radius_mm / tube.bending_stiffness / tube.material.recoverable_strain
            worst = np.maximum(worst, most * _bend_moments(places, moments, held))
    return worst


def _bend_moments(points: Points, about: Vectors, forces: Vectors) -> Float[np.ndarray, "robot"]:
    """Return the largest moment across a rod, N mm, at the ends of its chords."""
    chords = np.diff(points, axis=1)
    lengths = np.linalg.norm(chords, axis=2, keepdims=True)
    ways = chords / np.maximum(lengths, np.finfo(float).tiny)
    moments = about[:, None] - np.cross(points, forces[:, None])
    worst = np.zeros(len(points))
    for ends in (moments[:, :-1], moments[:, 1:]):
        across = ends - np.sum(ends * ways, axis=2, keepdims=True) * ways
        worst = np.maximum(worst, np.linalg.norm(across, axis=2).max(axis=1))
    return worst
