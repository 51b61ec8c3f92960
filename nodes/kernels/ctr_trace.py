"""One configuration looked at closely, and the way from one to another."""

from numba import njit

from nodes.kernels.ctr_continuation import follow
from nodes.kernels.ctr_frames import place_frames
from nodes.kernels.ctr_options import OUTER
from nodes.kernels.ctr_outcomes import sections_of
from nodes.kernels.ctr_sections import cut_sections
from nodes.kernels.ctr_solve import FOR_SHAPE, weights_of
from nodes.kernels.ctr_torsion import untwist_through
from nodes.kernels.ctr_tuples import replace, zeros_like


@njit(**OUTER)
def trace(size, columns, tubes, joints, tips, places, scratch, angles):
    """Write frames and angles at many places of one solved configuration; return the steps.

    Parameters
    ----------
    joints : Joints, of which the first row counts; tips : (n,) its angles at the tips.
    places : (p,) rising, mm from the entry; each becomes a node.
    scratch : Scratch, with room for that many nodes: its frames and places are written.
    angles : (nodes, n) written: psi of all tubes.
    """
    weights = weights_of(size, tubes)
    sections, nodes = sections_of(scratch, 0), scratch.nodes
    count = cut_sections(tubes, joints.translations, 0, FOR_SHAPE, sections)
    state = zeros_like(columns)
    for i in range(len(size)):
        state = replace(state, i, tips[i + 1] - tips[0])
    steps = untwist_through(
        size, weights, sections, count, state, zeros_like(columns), places, nodes
    )
    beta, theta = joints.translations[0, 0], joints.rotations[0, 0]
    entry, _ = place_frames(size, weights, beta, theta, tubes.base, sections, nodes, steps)
    for node in range(steps + 1):
        first = entry
        for i in range(len(size)):
            first += weights[i + 1] * (nodes.state[steps, i] - nodes.state[node, i])
        angles[node, 0] = first
        for i in range(len(size)):
            angles[node, i + 1] = first + nodes.state[node, i]
    return steps


@njit(**OUTER)
def follow_row(size, columns, tubes, rotations, translations, tips, scratch):
    """Follow a motion and return the share of it that is safe.

    Parameters
    ----------
    rotations, translations : (3, n) as `follow` takes them.
    tips : (n,) angles at the tips, at the start; written: where the motion ends or snaps.
    """
    weights = weights_of(size, tubes)
    sections, nodes = sections_of(scratch, 0), scratch.nodes
    x = size
    for i in range(len(size)):
        x = replace(x, i, tips[i + 1] - tips[0])
    x, share, steps = follow(
        size, columns, weights, tubes, rotations, translations, x, FOR_SHAPE, sections, nodes
    )
    there = rotations[0, 0] + share * (rotations[1, 0] - rotations[0, 0])
    beta = translations[0, 0] + share * (translations[1, 0] - translations[0, 0])
    tips[0] = there
    for i in range(len(size)):
        swing = nodes.state[steps, i] + beta * nodes.rate[steps, i]
        tips[0] += weights[i + 1] * (swing - x[i])
    for i in range(len(size)):
        tips[i + 1] = tips[0] + x[i]
    return share
