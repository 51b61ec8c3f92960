"""Arcs and chains of arcs through given points [Yang2019] Sec. II-B and II-C."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from nodes.errors import BadInput
from nodes.geometry.arrays import freeze_arrays
from nodes.mechanics.constant_curvature import Arcs, pose_arcs

# What an arc is; the first two numbers are the flags of [Yang2019] Table 1.
ARC = 1
STRAIGHT = 2
"""Case I: the point lies straight ahead."""
EMPTY = 3
"""Case II: the point is the start itself; no arc is taken, though a full circle would be one."""
IMPOSSIBLE = 4
"""Case III: the point lies straight behind, or is none: it follows on such a one."""

# Sine of the angle off the axis below which a point lies on it: some hundred times the rounding of
# a few turned frames, and 1e-10 mm aside at 100 mm.
ON_AXIS = 1e-12
# A point nearer than this to the start is the start: what 100 mm are rounded to, and some.
AT_START_MM = 1e-12


@dataclass(frozen=True)
class FittedArcs:
    """Arcs through points, and which of them exist.

    Parameters
    ----------
    arcs : (..., section); nan where impossible.
    kinds : (..., section) ARC, STRAIGHT, EMPTY or IMPOSSIBLE.
    """

    arcs: Arcs
    kinds: Int[np.ndarray, "*chain section"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


def fit_arcs(ends_mm: Float[np.ndarray, "*n section 3"]) -> FittedArcs:
    """Return the arc from the origin, along +z there, to each point.

    theta = atan2(y, x), eq. (15); gamma = 2 rho / (rho^2 + z^2), eq. (16); psi = 2 atan2(rho, z),
    which is eq. (17) on both of its branches and keeps all digits near 0 and pi;
    l = |C| (psi / 2) / sin(psi / 2), eq. (18), with sin(psi / 2) = rho / |C|.

    Parameters
    ----------
    ends_mm : (..., section, 3) in the frame of each arc's start, mm.
    """
    x, y, z = np.moveaxis(ends_mm, -1, 0)
    aside = np.hypot(x, y)
    reach = np.hypot(aside, z)
    kinds = _tell_kinds(aside, z, reach)
    bent, none = kinds == ARC, np.where(kinds == IMPOSSIBLE, np.nan, 0.0)
    distance = np.where(bent, reach, 1.0)
    sine = np.where(bent, aside, 1.0) / distance
    arcs = Arcs(
        bending_plane_rad=np.where(bent, np.arctan2(y, x), none),
        curvature_per_mm=np.where(bent, 2 * sine / distance, none),
        length_mm=np.where(bent, distance * np.arctan2(aside, z) / sine, reach + none),
    )
    return FittedArcs(arcs, kinds)


def _tell_kinds(
    aside: Float[np.ndarray, "*n"], ahead: Float[np.ndarray, "*n"], reach: Float[np.ndarray, "*n"]
) -> Int[np.ndarray, "*n"]:
    on_axis = np.where(ahead > 0, STRAIGHT, IMPOSSIBLE)
    kinds = np.where(aside <= ON_AXIS * reach, on_axis, ARC)
    kinds = np.where(reach <= AT_START_MM, EMPTY, kinds)
    return np.where(np.isnan(reach), IMPOSSIBLE, kinds)


def fit_chain(
    nodes_mm: Float[np.ndarray, "*chain node 3"], first_axes: Float[np.ndarray, "3 3"]
) -> FittedArcs:
    """Return the arcs that join nodes one after the other, each leaving along the one before.

    [Yang2019] Sec. II-C: each next node is seen from the frame at the end of the arc before,
    eq. (19), (20), and fitted there.

    Parameters
    ----------
    nodes_mm : (..., node, 3), the base first, mm.
    first_axes : (3, 3) rotation; its third column is the direction of insertion, its first one the
        azimuth 0 of the first arc.

    Returns
    -------
    (..., node - 1) arcs; from an impossible one on, all of a chain are impossible.
    """
    steps = np.diff(nodes_mm, axis=-2)
    axes = np.broadcast_to(first_axes, (*steps.shape[:-2], 3, 3))
    sections = []
    for section in range(steps.shape[-2]):
        # As a row times the axes: what the step is along each of them.
        sections.append(fit_arcs(steps[..., section, None, :] @ axes))
        axes = axes @ pose_arcs(sections[-1].arcs)[..., 0, :3, :3]
    return _join(sections)


def _join(sections: list[FittedArcs]) -> FittedArcs:
    planes = [fitted.arcs.bending_plane_rad for fitted in sections]
    curvatures = [fitted.arcs.curvature_per_mm for fitted in sections]
    lengths = [fitted.arcs.length_mm for fitted in sections]
    kinds = [fitted.kinds for fitted in sections]
    arcs = Arcs(*(np.concatenate(parts, -1) for parts in (planes, curvatures, lengths)))
    return FittedArcs(arcs, np.concatenate(kinds, -1))


def check_possible(fitted: FittedArcs) -> None:
    """Refuse chains with a section that no arc can be.

    Raises
    ------
    BadInput with the number of the first node that cannot be reached.
    """
    if not (fitted.kinds == IMPOSSIBLE).any():
        return
    section = int(np.argwhere(fitted.kinds == IMPOSSIBLE)[:, -1].min())
    raise BadInput(
        f"node {section + 1} lies straight behind node {section}",
        "an arc leaves along the one before it, and none turns back onto its own axis"
        " [Yang2019] Case III",
        "move that node aside, or put another one between",
    )
