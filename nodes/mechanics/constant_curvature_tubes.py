"""Nested tubes as arcs: how curvatures combine, who dominates, lengths [Yang2019] Sec. II-A, II-B.

Torsion is left out, as the paper does (its J G = 0 stands for tubes that never twist): exact for
one tube and for tubes whose planes agree or oppose, an estimate for all others.
"""

import numpy as np
from jaxtyping import Float, Int

from nodes.errors import BadInput
from nodes.mechanics.constant_curvature import Arcs
from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot

Rows = Float[np.ndarray, "*n tube"]


def combine_curvatures(
    bending_plane_rad: Rows, curvature_per_mm: Rows, stiffness: Rows
) -> tuple[Float[np.ndarray, "*n"], Float[np.ndarray, "*n"]]:
    """Return plane and curvature of tubes that share one axis, [Yang2019] eq. (4) to (7), balanced.

    u = sum_i K_i u_i / sum_i K_i, the least of the bending energy sum_i K_i |u - u_i|^2 / 2.

    Parameters
    ----------
    bending_plane_rad : (..., tube) azimuth that each tube bends to by itself, rad.
    curvature_per_mm : (..., tube) of each tube by itself, 1/mm; 0 for a straight part.
    stiffness : (..., tube) E I, N mm^2.

    Returns
    -------
    azimuth (...), rad, and curvature (...), 1/mm.
    """
    weights = stiffness / stiffness.sum(-1, keepdims=True)
    x = (weights * curvature_per_mm * np.cos(bending_plane_rad)).sum(-1)
    y = (weights * curvature_per_mm * np.sin(bending_plane_rad)).sum(-1)
    return np.asarray(np.arctan2(y, x)), np.asarray(np.hypot(x, y))


def count_dominating(stiffness: Rows, threshold: float) -> Int[np.ndarray, "*n"]:
    """Return how many of the outermost tubes dominate all that lie inside of them.

    A tube, or else a balanced pair of tubes, dominates where its stiffness is at least `threshold`
    times that of all inner ones together ([Yang2019] Sec. II-A: 6 in practice, 8 in its
    simulations). A section keeps its shape while inner tubes move through it, as follow-the-leader
    deployment wants it, only where one or two dominate.

    Parameters
    ----------
    stiffness : (..., tube) E I, N mm^2, innermost first.
    threshold : eta, without unit.

    Returns
    -------
    (...) 1 or 2; the number of all tubes where neither one nor two dominate the rest.
    """
    inner = np.cumsum(stiffness, -1)
    tubes = stiffness.shape[-1]
    found = np.full(stiffness.shape[:-1], tubes)
    for count in (2, 1):
        if tubes > count:
            rest = inner[..., -count - 1]
            found = np.where(inner[..., -1] - rest >= threshold * rest, count, found)
    return found


def combine_section(
    bending_plane_rad: Rows, curvature_per_mm: Rows, stiffness: Rows, threshold: float
) -> tuple[Float[np.ndarray, "*n"], Float[np.ndarray, "*n"]]:
    """Return plane and curvature of a section, inner tubes yielding to what dominates, eq. (5).

    Parameters and returned values are those of `combine_curvatures` and `count_dominating`,
    innermost tube first.
    """
    tubes = stiffness.shape[-1]
    count = count_dominating(stiffness, threshold)[..., None]
    acting = np.where(np.arange(tubes) >= tubes - count, stiffness, 0.0)
    return combine_curvatures(bending_plane_rad, curvature_per_mm, acting)


def is_follow_the_leader(robot: ConcentricTubeRobot, threshold: float) -> bool:
    """Return whether a robot keeps the guidelines for follow-the-leader deployment.

    [Yang2019] Sec. II-A: a) tubes grow longer from outside to inside, each straight and then one
    arc; b), c) in each section the outermost tube, or the outermost pair, dominates all that is
    inside and moves on. They are what that paper designs by, not a proof: how far the body leaves
    the way of the tip is for the mechanics to measure.

    Parameters
    ----------
    threshold : eta, as in `count_dominating`.
    """
    lengths = np.array([tube.length_mm for tube in robot.tubes])
    stiffness = np.array([tube.bending_stiffness for tube in robot.tubes])
    counts = [count_dominating(stiffness[:end], threshold) for end in range(1, len(stiffness) + 1)]
    return bool((np.diff(lengths) < 0).all() and max(counts) <= 2)


def measure_dominance(
    stiffness: Float[np.ndarray, "tube"], curvature_per_mm: Float[np.ndarray, "tube"]
) -> Float[np.ndarray, "outer"]:
    """Return eta of each tube but the innermost, [Yang2019] eq. (8).

    eta_j = E_j I_j gamma_j / sum_{p < j} E_p I_p gamma_p; equal curvatures give the ratio of the
    stiffnesses alone, which is what the paper compares to 6 and to 8. Infinite where all inner
    tubes are straight.

    Parameters
    ----------
    stiffness, curvature_per_mm : (tube,), innermost first, N mm^2 and 1/mm.
    """
    moments = stiffness * abs(curvature_per_mm)
    inner = np.cumsum(moments)[:-1]
    known = inner > 0
    return np.where(known, moments[1:] / np.where(known, inner, 1.0), np.inf)


def size_dominating_tube(
    inner_diameter_mm: float, young_modulus_mpa: float, inner_stiffness: float, threshold: float
) -> float:
    """Return the outer diameter, mm, at which a tube comes to dominate the inner ones.

    [Yang2019] eq. (8) for equal curvatures, with I = pi / 64 (OD^4 - ID^4); for others, give
    sum_p E_p I_p gamma_p / gamma_j as the inner stiffness.

    Parameters
    ----------
    inner_diameter_mm : of the tube that is to dominate, mm.
    young_modulus_mpa : of that tube, MPa.
    inner_stiffness : sum of E I of all inner tubes, N mm^2.
    threshold : eta, without unit.
    """
    area_moment = threshold * inner_stiffness / young_modulus_mpa
    return float((inner_diameter_mm**4 + 64 / np.pi * area_moment) ** 0.25)


def insertion_lengths(
    sections_mm: Float[np.ndarray, "*n tube"],
) -> Float[np.ndarray, "*n tube"]:
    """Return how far each tube is inserted, [Yang2019] eq. (2).

    Parameters
    ----------
    sections_mm : (..., tube) length over which each tube is the outermost, innermost first, mm.
    """
    return np.cumsum(sections_mm[..., ::-1], -1)[..., ::-1]


def total_lengths(
    insertions_mm: Float[np.ndarray, "tube"], drives_mm: Float[np.ndarray, "tube"]
) -> Float[np.ndarray, "tube"]:
    """Return the length of each tube with the part inside of its drive, [Yang2019] eq. (3).

    Parameters
    ----------
    insertions_mm, drives_mm : (tube,) innermost first, mm.

    Raises
    ------
    BadInput unless insertions do not grow outwards, and drive parts shrink outwards and are there.
    """
    if (np.diff(insertions_mm) > 0).any() or (insertions_mm < 0).any():
        raise BadInput(
            f"insertions of {insertions_mm.tolist()} mm",
            "no tube is inserted farther than the one inside of it, none less than 0",
            "list the tubes innermost first",
        )
    if (np.diff(drives_mm) >= 0).any() or (drives_mm <= 0).any():
        raise BadInput(
            f"drive parts of {drives_mm.tolist()} mm",
            "each tube's drive part is shorter than that of the tube inside of it, and above 0",
            "give inner tubes longer drive parts",
        )
    return insertions_mm + drives_mm


def arcs_of_robot(robot: ConcentricTubeRobot, configuration: ConcentricTubeConfiguration) -> Arcs:
    """Return the robot's axis in its base frame as arcs, tubes bending each other without twist.

    Between two places where a tube ends or becomes curved, stiffnesses and curvatures are constant,
    straight parts among them, so that eq. (5) holds there; nothing is taken for dominating.
    """
    starts = configuration.translations_mm
    bends = starts + np.array([tube.straight_length_mm for tube in robot.tubes])
    tips = starts + np.array([tube.length_mm for tube in robot.tubes])
    breaks = np.unique(np.concatenate([[0.0], bends, tips]).clip(0.0))
    middles = (breaks[1:] + breaks[:-1])[:, None] / 2
    stiffness = np.array([tube.bending_stiffness for tube in robot.tubes]) * (middles < tips)
    curvature = np.array([tube.curvature_per_mm for tube in robot.tubes]) * (middles > bends)
    planes = np.broadcast_to(configuration.rotations_rad, stiffness.shape)
    plane, combined = combine_curvatures(planes, curvature, stiffness)
    return Arcs(plane, combined, np.diff(breaks))
