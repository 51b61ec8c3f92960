"""What kernels of concentric tubes take and give, configuration after configuration."""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.ctr_borrow import borrow
from nodes.kernels.ctr_nodes import Nodes
from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_sections import Sections, Tubes


class Joints(NamedTuple):
    """Joint values of k configurations, innermost tube first.

    rotations, translations : (k, n) rad and mm.
    start : (k, n) angles at the tips to start from, rad; (0, n) to start without.
    """

    rotations: np.ndarray
    translations: np.ndarray
    start: np.ndarray


class Outcomes(NamedTuple):
    """What is found for k configurations; an array without rows is not asked for.

    Frames, places and rotation vectors are in the axes of the robot's base.

    status : (k,) int64, SOLVED, NO_SOLUTION, NOT_CONVERGED or UNSTABLE.
    tips, entries, twists : (k, n) angles at the tips and at the entry, rad; twist there, rad/mm.
    frame : (k, 12) bending frame at the tip by rows, then its place, mm.
    determinant, residual : (k,) of d theta / d tip angles; largest, rad, before the last step.
    least : (k,) or (0,) of `least_determinant`; not above 0 where a corner is unstable.
    places : (k, p) mm from the entry, even; points : (k, p, 3) mm.
    jacobian : (k, 6, 2 n) of the tip, by rotations, then translations.
    """

    status: np.ndarray
    tips: np.ndarray
    entries: np.ndarray
    twists: np.ndarray
    frame: np.ndarray
    determinant: np.ndarray
    residual: np.ndarray
    least: np.ndarray
    places: np.ndarray
    points: np.ndarray
    jacobian: np.ndarray


class Scratch(NamedTuple):
    """Room for one configuration: nodes, joint values on the way, twists of the tip; and for eight:
    sections and how many of them, lanes for the start."""

    sections: Sections
    nodes: Nodes
    rotations: np.ndarray
    translations: np.ndarray
    twists: np.ndarray
    counts: np.ndarray
    group: np.ndarray


@njit(**INNER)
def borrow_tubes(t):
    """Return the tubes without reference counts."""
    return Tubes(
        borrow(t.bending), borrow(t.torsion), borrow(t.curvature), borrow(t.straight),
        borrow(t.length), borrow(t.weight), borrow(t.base),
    )  # fmt: skip


@njit(**INNER)
def borrow_joints(j):
    """Return the joint values without reference counts."""
    return Joints(borrow(j.rotations), borrow(j.translations), borrow(j.start))


@njit(**INNER)
def borrow_scratch(scratch):
    """Return the scratch without reference counts."""
    s, n = scratch.sections, scratch.nodes
    sections = Sections(
        borrow(s.place), borrow(s.share), borrow(s.drive), borrow(s.coupled), borrow(s.steps),
        borrow(s.owner),
    )  # fmt: skip
    nodes = Nodes(
        borrow(n.place), borrow(n.section), borrow(n.state), borrow(n.rate), borrow(n.shift),
        borrow(n.shift_rate), borrow(n.shift_end), borrow(n.frame), borrow(n.lanes),
        borrow(n.ends), borrow(n.samples),
    )  # fmt: skip
    rotations, translations = borrow(scratch.rotations), borrow(scratch.translations)
    twists, counts = borrow(scratch.twists), borrow(scratch.counts)
    return Scratch(sections, nodes, rotations, translations, twists, counts, borrow(scratch.group))


@njit(**INNER)
def sections_of(scratch, lane):
    """Return the sections of one of eight configurations."""
    s = scratch.sections
    return Sections(
        s.place[lane], s.share[lane], s.drive[lane], s.coupled[lane], s.steps[lane], s.owner[lane]
    )


@njit(**INNER)
def borrow_outcomes(o):
    """Return the outcomes without reference counts."""
    return Outcomes(
        borrow(o.status), borrow(o.tips), borrow(o.entries), borrow(o.twists), borrow(o.frame),
        borrow(o.determinant), borrow(o.residual), borrow(o.least), borrow(o.places),
        borrow(o.points), borrow(o.jacobian),
    )  # fmt: skip
