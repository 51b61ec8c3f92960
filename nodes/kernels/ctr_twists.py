"""How the tip moves with the angles along the robot and with the places of breaks.

If angle psi_j changes, the robot turns about -share_j x_j, x_j the axis that tube j bends towards:

    d phi = - sum_j int share_j x_j d psi_j ds                 d p = the same x (p_tip - p)

with x_j' = psi_j' y_j - k_j t and t' = k_j x_j + l_j y_j, where k_j and l_j are the curvature along
x_j and y_j. Each step is integrated by the quintic through values and two derivatives at its ends.
Eight steps go through it at once, as lanes.
If a break moves, curvature there changes from that above it to that below.
"""

from numba import njit

from nodes.kernels.ctr_lanes import LANES, load_rows, spread, spread_rows, store_rows
from nodes.kernels.ctr_nodes import ANGLES, ARM, FRAME, INPUTS, RATES, ROWS, SUMS, TUBE, TUBES
from nodes.kernels.ctr_options import INNER, INSIDE
from nodes.kernels.ctr_rotations import cross, rotate
from nodes.kernels.ctr_sincos import all_sincos
from nodes.kernels.ctr_tuples import prepend, replace, take


@njit(**INNER)
def integrate_twists(size, weights, base, sections, count, nodes, steps, work):
    """Write the twist of the tip (place, then rotation vector) by each column.

    Parameters
    ----------
    size, weights, sections, count, nodes, steps : solved, shifted and frames placed.
    base : (12,) frame of the entry by rows, then its place mm.
    work : (2 m + 1, 6) written: by the angles at the tips, by the translations of the outer tubes
        (with the angles at the tips held), and by all at once.
    """
    for column in range(2 * len(size) + 1):
        for i in range(6):
            work[column, i] = 0.0
    for first in range(0, steps, LANES):
        last = min(first + LANES, steps)
        for upper in range(2):
            _gather_ends(size, first, last, upper, nodes)
            _weigh_tubes(size, weights, first // LANES * ROWS, upper, nodes)
            _add_columns(size, weights, first // LANES * ROWS, upper, nodes)
        for column in range(2 * len(size)):
            for i in range(6):
                for lane in range(last - first):
                    work[column, i] += nodes.ends[SUMS + 6 * column + i, lane]
    node = 0
    for k in range(count):
        _add_break(size, k, node, sections, nodes, work)
        if sections.place[k] > sections.place[k + 1]:
            node += sections.steps[k]
    _shift_all(size, base, count, steps, sections, nodes, work)


@njit(**INNER)
def _gather_ends(size, first, last, upper, nodes):
    """Write frame and columns at the lower (0) or upper (1) ends of up to eight steps to lanes."""
    m, ends = len(size), nodes.ends
    for k in range(first, last):
        node, lane = k + 1 - upper, k - first
        for i in range(9):
            ends[FRAME + i, lane] = nodes.frame[node, i]
        for i in range(3):
            ends[FRAME + 9 + i, lane] = nodes.frame[0, 9 + i] - nodes.frame[node, 9 + i]
        for i in range(m * m):
            ends[ANGLES + i, lane] = nodes.state[node, m + i]
            ends[RATES + i, lane] = nodes.rate[node, m + i]
            rate = nodes.shift_rate[k, m + i] if upper == 1 else nodes.shift_end[k, m + i]
            ends[ANGLES + m * m + i, lane] = nodes.shift[node, m + i]
            ends[RATES + m * m + i, lane] = rate


@njit(**INNER)
def _weigh_tubes(size, weights, block, upper, nodes):
    """Write for each tube what its angle does to the tip, and its place among the others."""
    m, lanes, row = len(size), nodes.lanes, block + INPUTS
    share = load_rows(weights, lanes, row + 4 * m)
    drive = load_rows(weights, lanes, row + 5 * m + 1)
    zero, one = spread(0.0), spread(1.0)
    sines, cosines = all_sincos(load_rows(size, lanes, row + 2 * m * upper))
    sine, cosine = prepend(zero, sines), prepend(one, cosines)
    turning = prepend(zero, load_rows(size, lanes, row + m + 2 * m * upper))
    c, z, c1, z1, first = share[0], zero, zero, zero, zero
    for j in range(1, m + 1):
        c += share[j] * cosine[j]
        z += share[j] * sine[j]
        c1 -= share[j] * sine[j] * turning[j]
        z1 += share[j] * cosine[j] * turning[j]
        first -= weights[j] * turning[j]
    (h,) = load_rows((0.0,), lanes, block)
    sign = 2.0 * upper - 1.0
    for j in range(m + 1):
        bend = c * cosine[j] + z * sine[j]
        lean = z * cosine[j] - c * sine[j]
        more = c1 * cosine[j] + z1 * sine[j] + turning[j] * lean
        own, bent = first + turning[j], -drive[j] * lean
        known = (share[j], sine[j], cosine[j], drive[j], bend)
        at = TUBES + TUBE * j
        store_rows(known, nodes.ends, at)
        _by_angle(h, -sign, share[j], sine[j], cosine[j], own, bend, lean, more, bent, at, nodes)


@njit(**INNER)
def _by_angle(h, sign, share, sine, cosine, own, bend, lean, more, bent, at, nodes):
    """Write what a tube's angle, its rate and second derivative at an end add to the tip's place
    and rotation, 18 numbers.

    own, bent : psi' and psi'' of the tube; bend, lean, more : k, l and k'.
    """
    frame, arm = load_rows((0.0,) * 9, nodes.ends, FRAME), load_rows((0.0,) * 3, nodes.ends, ARM)
    x = _across(frame, cosine, sine)
    y = _across(frame, -sine, cosine)
    t = (frame[2], frame[5], frame[8])
    zero = spread(0.0)
    a0 = _sum3(-share, x, zero, y, zero, t)
    a1 = _sum3(zero, x, -share * own, y, share * bend, t)
    a2 = _sum3(
        share * (own * own + bend * bend), x, -share * (bent - bend * lean), y,
        share * (own * lean + more), t,
    )  # fmt: skip
    b0 = cross(a0, arm)
    # The arm gets shorter by t: a0 x t = share y, a1 x t = -share psi' x, a0 x t' = -share l t.
    b1 = _sum3(spread(1.0), cross(a1, arm), -share, y, zero, t)
    b2 = _sum3(spread(1.0), cross(a2, arm), 2.0 * share * own, x, share * lean, t)
    h0, h1, h2 = h * 0.5, h * h * (sign * 0.1), h * h * h * (1 / 120)
    for i in range(3):
        store_rows((h0 * b0[i] + h1 * b1[i] + h2 * b2[i],), nodes.ends, at + 5 + i)
        store_rows((h0 * a0[i] + h1 * a1[i] + h2 * a2[i],), nodes.ends, at + 8 + i)
        store_rows((h1 * b0[i] + 2.0 * h2 * b1[i],), nodes.ends, at + 11 + i)
        store_rows((h1 * a0[i] + 2.0 * h2 * a1[i],), nodes.ends, at + 14 + i)
        store_rows((h2 * b0[i],), nodes.ends, at + 17 + i)
        store_rows((h2 * a0[i],), nodes.ends, at + 20 + i)


@njit(**INSIDE)
def _across(frame, x, y):
    return frame[0] * x + frame[1] * y, frame[3] * x + frame[4] * y, frame[6] * x + frame[7] * y


@njit(**INSIDE)
def _sum3(a, x, b, y, c, z):
    return (
        a * x[0] + b * y[0] + c * z[0],
        a * x[1] + b * y[1] + c * z[1],
        a * x[2] + b * y[2] + c * z[2],
    )


@njit(**INNER)
def _add_columns(size, weights, block, upper, nodes):
    """Write (lower end) or add (upper end) what each column does to the tip over the steps."""
    m, ends, zero = len(size), nodes.ends, spread(0.0)
    for column in range(2 * m):
        angle = prepend(zero, load_rows(size, ends, ANGLES + column * m))
        rate = prepend(zero, load_rows(size, ends, RATES + column * m))
        first, first_rate, along, across = zero, zero, zero, zero
        for j in range(1, m + 1):
            first -= weights[j] * angle[j]
            first_rate -= weights[j] * rate[j]
        for j in range(m + 1):
            share, sine, cosine, _, _ = load_rows((0.0,) * 5, ends, TUBES + TUBE * j)
            along -= share * sine * (first + angle[j])
            across += share * cosine * (first + angle[j])
        total = spread_rows((0.0,) * 6, 0.0)
        if upper == 1:
            total = load_rows((0.0,) * 6, ends, SUMS + 6 * column)
        for j in range(m + 1):
            _, sine, cosine, drive, bend = load_rows((0.0,) * 5, ends, TUBES + TUBE * j)
            turned, turned_rate = first + angle[j], first_rate + rate[j]
            second = -drive * (across * cosine - along * sine - bend * turned)
            by = load_rows((0.0,) * 18, ends, TUBES + TUBE * j + 5)
            for i in range(6):
                more = by[i] * turned + by[6 + i] * turned_rate + by[12 + i] * second
                total = replace(total, i, total[i] + more)
        store_rows(total, ends, SUMS + 6 * column)


@njit(**INNER)
def _arm(node, nodes):
    return (
        nodes.frame[0, 9] - nodes.frame[node, 9],
        nodes.frame[0, 10] - nodes.frame[node, 10],
        nodes.frame[0, 11] - nodes.frame[node, 11],
    )


@njit(**INNER)
def _add_break(size, k, node, sections, nodes, work):
    """Add to the column of the break's tube what moving it does: curvature changes at its place."""
    owner = sections.owner[k, 0]
    if owner == 0:
        return
    sines, cosines = all_sincos(take(size, nodes.state, node, 0))
    along = sections.share[k, 0] - (sections.share[k - 1, 0] if k > 0 else 0.0)
    across = 0.0
    for i in range(len(size)):
        gain = sections.share[k, i + 1] - (sections.share[k - 1, i + 1] if k > 0 else 0.0)
        along += gain * cosines[i]
        across += gain * sines[i]
    turned = rotate(take((0.0,) * 9, nodes.frame, node, 0), (-across, along, 0.0))
    moved = cross(turned, _arm(node, nodes))
    for i in range(3):
        work[len(size) + owner - 1, i] += moved[i]
        work[len(size) + owner - 1, 3 + i] += turned[i]


@njit(**INNER)
def _shift_all(size, base, count, steps, sections, nodes, work):
    """All tubes pushed out together: the curvature at the entry goes on for a little longer."""
    sines, cosines = all_sincos(take(size, nodes.state, steps, 0))
    along, across = 0.0, 0.0
    if count > 0:
        along = sections.share[count - 1, 0]
        for i in range(len(size)):
            along += sections.share[count - 1, i + 1] * cosines[i]
            across += sections.share[count - 1, i + 1] * sines[i]
    turned = rotate(take((0.0,) * 9, nodes.frame, steps, 0), (-across, along, 0.0))
    moved = cross(turned, _arm(steps, nodes))
    row = 2 * len(size)
    for i in range(3):
        work[row, i], work[row, 3 + i] = moved[i], turned[i]
    for i in range(3):
        work[row, i] += base[3 * i + 2]
