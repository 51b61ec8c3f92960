"""Torsion of nested tubes from the tip to the base, in the angles that they have at their tips.

The state is the angle of each outer tube to the innermost one, phi_i = psi_i - psi_1, its rate by
arc length, and columns of their derivatives by something, each as long as the angles. All moments
between tubes cancel, hence sum_i GJ_i psi_i is the same everywhere and the innermost tube's angle
follows [Dupont2010]. With (C, Z) = sum_j share_j (cos, sin)(phi_j), phi_1 = 0,

    psi_i'' = drive_i (sin(phi_i) C - cos(phi_i) Z)        [Rucker2010]
"""

from numba import njit

from nodes.kernels.ctr_options import INNER, INSIDE
from nodes.kernels.ctr_sincos import all_sincos
from nodes.kernels.ctr_tuples import add, put, replace, take
from nodes.kernels.nystroem_tables import ORDER_4, ORDER_8

HALF = ORDER_4.nodes[1]
FIRST_4, LAST_4 = ORDER_4.stages[1][0], ORDER_4.stages[2][1]
VALUES_4, RATES_4 = ORDER_4.values, ORDER_4.rates
N2, N3, N4, N5, N6, N7, N8 = ORDER_8.nodes[1:]
A2, A3, A4, A5, A6, A7, A8 = ORDER_8.stages[1:]
VALUES_8, RATES_8 = ORDER_8.values, ORDER_8.rates


@njit(**INSIDE)
def angles_of(size, state):
    """Return the angles of a state."""
    for i in range(len(size)):
        size = replace(size, i, state[i])
    return size


@njit(**INNER)
def accelerate(size, share, drive, state):
    """Return the second derivative of the state by arc length; `size` is as long as the angles."""
    m = len(size)
    sine, cosine = all_sincos(angles_of(size, state))
    along, across = share[0] + share[1] * cosine[0], share[1] * sine[0]
    for i in range(1, m):
        along += share[i + 1] * cosine[i]
        across += share[i + 1] * sine[i]
    bent = state
    for i in range(m):
        pull = drive[i + 1] * (sine[i] * along - cosine[i] * across)
        bent = replace(bent, i, pull + drive[0] * across)
    for column in range(m, len(state), m):
        less, more = -share[1] * sine[0] * state[column], share[1] * cosine[0] * state[column]
        for i in range(1, m):
            less -= share[i + 1] * sine[i] * state[column + i]
            more += share[i + 1] * cosine[i] * state[column + i]
        for i in range(m):
            own = (cosine[i] * along + sine[i] * across) * state[column + i]
            pull = drive[i + 1] * (own + sine[i] * less - cosine[i] * more)
            bent = replace(bent, column + i, pull + drive[0] * more)
    return bent


@njit(**INNER)
def step_order_4(size, share, drive, h, state, rate):
    """Return state and rate after one step of order 4 and length h (negative towards the base)."""
    g = h * h
    f1 = accelerate(size, share, drive, state)
    f2 = accelerate(size, share, drive, add(add(state, HALF * h, rate), FIRST_4 * g, f1))
    f3 = accelerate(size, share, drive, add(add(state, h, rate), LAST_4 * g, f2))
    for i in range(len(state)):
        pull = VALUES_4[0] * f1[i] + VALUES_4[1] * f2[i]
        state = replace(state, i, state[i] + h * rate[i] + g * pull)
        pull = RATES_4[0] * f1[i] + RATES_4[1] * f2[i] + RATES_4[2] * f3[i]
        rate = replace(rate, i, rate[i] + h * pull)
    return state, rate


@njit(**INNER)
def step_order_8(size, share, drive, h, state, rate):
    """Return state and rate after one step of order 8 and length h (negative towards the base).

    Written out, since the compiler keeps tuples of tuples in memory.
    """
    g, at = h * h, state
    f1 = accelerate(size, share, drive, state)
    for i in range(len(state)):
        pull = A2[0] * f1[i]
        at = replace(at, i, state[i] + N2 * h * rate[i] + g * pull)
    f2 = accelerate(size, share, drive, at)
    for i in range(len(state)):
        pull = A3[0] * f1[i] + A3[1] * f2[i]
        at = replace(at, i, state[i] + N3 * h * rate[i] + g * pull)
    f3 = accelerate(size, share, drive, at)
    for i in range(len(state)):
        pull = A4[0] * f1[i] + A4[1] * f2[i] + A4[2] * f3[i]
        at = replace(at, i, state[i] + N4 * h * rate[i] + g * pull)
    f4 = accelerate(size, share, drive, at)
    for i in range(len(state)):
        pull = A5[0] * f1[i] + A5[1] * f2[i] + A5[2] * f3[i] + A5[3] * f4[i]
        at = replace(at, i, state[i] + N5 * h * rate[i] + g * pull)
    f5 = accelerate(size, share, drive, at)
    for i in range(len(state)):
        pull = A6[0] * f1[i] + A6[1] * f2[i] + A6[2] * f3[i] + A6[3] * f4[i] + A6[4] * f5[i]
        at = replace(at, i, state[i] + N6 * h * rate[i] + g * pull)
    f6 = accelerate(size, share, drive, at)
    for i in range(len(state)):
        pull = (
            A7[0] * f1[i]
            + A7[1] * f2[i]
            + A7[2] * f3[i]
            + A7[3] * f4[i]
            + A7[4] * f5[i]
            + A7[5] * f6[i]
        )
        at = replace(at, i, state[i] + N7 * h * rate[i] + g * pull)
    f7 = accelerate(size, share, drive, at)
    for i in range(len(state)):
        pull = (
            A8[0] * f1[i]
            + A8[1] * f2[i]
            + A8[2] * f3[i]
            + A8[3] * f4[i]
            + A8[4] * f5[i]
            + A8[5] * f6[i]
            + A8[6] * f7[i]
        )
        at = replace(at, i, state[i] + N8 * h * rate[i] + g * pull)
    f8 = accelerate(size, share, drive, at)
    for i in range(len(state)):
        pull = (
            VALUES_8[0] * f1[i]
            + VALUES_8[2] * f3[i]
            + VALUES_8[3] * f4[i]
            + VALUES_8[4] * f5[i]
            + VALUES_8[5] * f6[i]
            + VALUES_8[6] * f7[i]
        )
        at = replace(at, i, state[i] + h * rate[i] + g * pull)
        pull = (
            RATES_8[0] * f1[i]
            + RATES_8[2] * f3[i]
            + RATES_8[3] * f4[i]
            + RATES_8[4] * f5[i]
            + RATES_8[5] * f6[i]
            + RATES_8[6] * f7[i]
            + RATES_8[7] * f8[i]
        )
        rate = replace(rate, i, rate[i] + h * pull)
    return at, rate


@njit(**INNER)
def untwist_coarsely(size, shares, sections, count, state, rate):
    """Integrate from the tip to the entry with one step of order 4 a section.

    Parameters
    ----------
    size, shares : tuples as long as the angles and as the tubes; their values do not matter.
    sections, count : of `cut_sections`.
    state, rate : at the tip.
    """
    for k in range(count):
        h = sections.place[k + 1] - sections.place[k]
        if sections.coupled[k] and h < 0.0:
            share, drive = take(shares, sections.share, k, 0), take(shares, sections.drive, k, 0)
            state, rate = step_order_4(size, share, drive, h, state, rate)
        else:
            state = add(state, h, rate)
    return state, rate


@njit(**INNER)
def untwist(size, shares, sections, count, state, rate, nodes):
    """Integrate from the tip to the entry to full accuracy and keep all nodes.

    Parameters
    ----------
    size, shares, sections, count, state, rate : as for `untwist_coarsely`.
    nodes : Nodes, written: place, section, state, rate.

    Returns
    -------
    State and rate at the entry, number of steps.
    """
    node = 0
    put(state, nodes.state, 0, 0)
    put(rate, nodes.rate, 0, 0)
    for k in range(count):
        length = sections.place[k] - sections.place[k + 1]
        if length <= 0.0:
            continue
        share, drive = take(shares, sections.share, k, 0), take(shares, sections.drive, k, 0)
        steps = sections.steps[k]
        for step in range(steps):
            h = -length / steps
            if sections.coupled[k]:
                state, rate = step_order_8(size, share, drive, h, state, rate)
            else:
                state = add(state, h, rate)
            nodes.place[node] = sections.place[k] - step * length / steps
            nodes.section[node] = k
            node += 1
            put(state, nodes.state, node, 0)
            put(rate, nodes.rate, node, 0)
    nodes.place[node] = 0.0
    return state, rate, node


@njit(**INNER)
def untwist_through(size, shares, sections, count, state, rate, places, nodes):
    """Integrate as `untwist` does and stop at given places, too; return the number of steps.

    places : (n,) rising, mm from the entry; those beyond the robot are passed over.
    """
    node, wanted = 0, places.shape[0] - 1
    put(state, nodes.state, 0, 0)
    put(rate, nodes.rate, 0, 0)
    for k in range(count):
        share, drive = take(shares, sections.share, k, 0), take(shares, sections.drive, k, 0)
        longest = (sections.place[k] - sections.place[k + 1]) / sections.steps[k]
        at = sections.place[k]
        while at > sections.place[k + 1]:
            while wanted >= 0 and places[wanted] >= at:
                wanted -= 1
            stop = max(sections.place[k + 1], at - longest)
            if wanted >= 0 and places[wanted] > stop:
                stop = places[wanted]
            state, rate = step_order_8(size, share, drive, stop - at, state, rate)
            nodes.place[node], nodes.section[node] = at, k
            node, at = node + 1, stop
            put(state, nodes.state, node, 0)
            put(rate, nodes.rate, node, 0)
    nodes.place[node] = 0.0
    return node
