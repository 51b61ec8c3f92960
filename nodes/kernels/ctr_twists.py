"""How the tip moves with the angles along the robot and with the places of breaks.

If angle psi_j changes, the robot turns about -share_j x_j, x_j the axis that tube j bends towards:

    d phi = - sum_j int share_j x_j d psi_j ds                 d p = the same x (p_tip - p)

with x_j' = psi_j' y_j - k_j t and t' = k_j x_j + l_j y_j, where k_j and l_j are the curvature along
x_j and y_j. Each step is integrated by the quintic through values and two derivatives at its ends.
If a break moves, curvature there changes from that above it to that below.
"""

from numba import njit

from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_pose import all_sincos
from nodes.kernels.ctr_rotations import cross, rotate
from nodes.kernels.ctr_tuples import prepend, take


@njit(**INNER)
def integrate_twists(size, weights, sections, count, nodes, steps, work):
    """Write the twist of the tip (place, then rotation vector, base frame) by each column.

    Parameters
    ----------
    size, weights, sections, count, nodes, steps : solved, shifted and frames placed.
    work : (2 m + 1, 10) written, the first six of a row: by the angles at the tips, by the
        translations of the outer tubes (with the angles at the tips held), and by all at once.
    """
    m = len(size)
    for column in range(2 * m + 1):
        for i in range(6):
            work[column, i] = 0.0
    for k in range(steps):
        if _is_curved(weights, nodes.section[k], sections):
            _add_end(size, weights, k, k + 1, 1.0, sections, nodes, work)
            _add_end(size, weights, k, k, -1.0, sections, nodes, work)
    node = 0
    for k in range(count):
        _add_break(size, k, node, sections, nodes, work)
        if sections.place[k] > sections.place[k + 1]:
            node += sections.steps[k]
    _shift_all(size, count, steps, sections, nodes, work)


@njit(**INNER)
def _is_curved(weights, section, sections):
    curved = False
    for share in take(weights, sections.share, section, 0):
        curved = curved or share != 0.0
    return curved


@njit(**INNER)
def _add_end(size, weights, k, node, sign, sections, nodes, work):
    """Add one end of step k to the integrals of all columns; `sign` is 1 at its lower end."""
    section = nodes.section[k]
    share = take(weights, sections.share, section, 0)
    drive = take(weights, sections.drive, section, 0)
    angle, rate = take(size, nodes.state, node, 0), take(size, nodes.rate, node, 0)
    sines, cosines = all_sincos(angle)
    sine, cosine = prepend(0.0, sines), prepend(1.0, cosines)
    turning = prepend(0.0, rate)
    c, z, c1, z1, first = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(len(weights)):
        c, z = c + share[j] * cosine[j], z + share[j] * sine[j]
        c1 -= share[j] * sine[j] * turning[j]
        z1 += share[j] * cosine[j] * turning[j]
        first -= weights[j] * turning[j]
    _turn_columns(size, weights, share, sine, cosine, k, node, sign, nodes, work)
    h = nodes.place[k] - nodes.place[k + 1]
    for j in range(len(weights)):
        if share[j] != 0.0:
            own = first + turning[j]
            bend = c * cosine[j] + z * sine[j]
            lean = z * cosine[j] - c * sine[j]
            more = c1 * cosine[j] + z1 * sine[j] + turning[j] * lean
            by = _by_angle(h, sign, node, share[j], sine[j], cosine[j], own, bend, lean, more,
                           -drive[j] * lean, nodes)  # fmt: skip
            _add_tube(size, weights, j, drive[j], bend, sine[j], cosine[j], k, node, sign, by,
                      nodes, work)  # fmt: skip


@njit(**INNER)
def _turn_columns(size, weights, share, sine, cosine, k, node, sign, nodes, work):
    """Write to `work[:, 6:]` of each column d C, d Z, d psi_1 and d psi_1'."""
    m = len(size)
    for column in range(2 * m):
        first, first_rate, along, across = 0.0, 0.0, 0.0, 0.0
        for i in range(m):
            angle, rate = _column(m, column, i, k, node, sign, nodes)
            first -= weights[i + 1] * angle
            first_rate -= weights[i + 1] * rate
            along -= share[i + 1] * sine[i + 1] * angle
            across += share[i + 1] * cosine[i + 1] * angle
        for j in range(m + 1):
            along -= share[j] * sine[j] * first
            across += share[j] * cosine[j] * first
        work[column, 6], work[column, 7] = along, across
        work[column, 8], work[column, 9] = first, first_rate


@njit(**INNER)
def _column(m, column, i, k, node, sign, nodes):
    """Return how angle i and its rate change at an end of step k."""
    if column < m:
        at = m + column * m + i
        return nodes.state[node, at], nodes.rate[node, at]
    at = (column - m + 1) * m + i
    if sign > 0.0:
        return nodes.shift[node, at], nodes.shift_end[k, at]
    return nodes.shift[node, at], nodes.shift_rate[k, at]


@njit(**INNER)
def _by_angle(h, sign, node, share, sine, cosine, own, bend, lean, more, bent, nodes):
    """Return what a tube's angle, its rate and second derivative at an end add to the tip's place
    and rotation, 18 numbers.

    own, bent : psi' and psi'' of the tube; bend, lean, more : k, l and k'.
    """
    frame = take((0.0,) * 9, nodes.frame, node, 0)
    x = rotate(frame, (cosine, sine, 0.0))
    y = rotate(frame, (-sine, cosine, 0.0))
    t = (frame[2], frame[5], frame[8])
    arm = _arm(node, nodes)
    a0 = _sum3(-share, x, 0.0, y, 0.0, t)
    a1 = _sum3(0.0, x, -share * own, y, share * bend, t)
    a2 = _sum3(
        share * (own * own + bend * bend), x, -share * (bent - bend * lean), y,
        share * (own * lean + more), t,
    )  # fmt: skip
    b0 = cross(a0, arm)
    # The arm gets shorter by t: a0 x t = share y, a1 x t = -share psi' x, a0 x t' = -share l t.
    b1 = _sum3(1.0, cross(a1, arm), -share, y, 0.0, t)
    b2 = _sum3(1.0, cross(a2, arm), 2 * share * own, x, share * lean, t)
    h0, h1, h2 = h / 2, sign * h * h / 10, h * h * h / 120
    p0, r0 = _sum3(h0, b0, h1, b1, h2, b2), _sum3(h0, a0, h1, a1, h2, a2)
    p1, r1 = _sum3(h1, b0, 2 * h2, b1, 0.0, t), _sum3(h1, a0, 2 * h2, a1, 0.0, t)
    p2, r2 = _sum3(h2, b0, 0.0, t, 0.0, t), _sum3(h2, a0, 0.0, t, 0.0, t)
    return p0 + r0 + p1 + r1 + p2 + r2


@njit(**INNER)
def _arm(node, nodes):
    return (
        nodes.frame[0, 9] - nodes.frame[node, 9],
        nodes.frame[0, 10] - nodes.frame[node, 10],
        nodes.frame[0, 11] - nodes.frame[node, 11],
    )


@njit(**INNER)
def _sum3(a, x, b, y, c, z):
    return (
        a * x[0] + b * y[0] + c * z[0],
        a * x[1] + b * y[1] + c * z[1],
        a * x[2] + b * y[2] + c * z[2],
    )


@njit(**INNER)
def _add_tube(size, weights, j, drive, bend, sine, cosine, k, node, sign, by, nodes, work):
    m = len(size)
    for column in range(2 * m):
        turned, rate = work[column, 8], work[column, 9]
        if j > 0:
            angle, angle_rate = _column(m, column, j - 1, k, node, sign, nodes)
            turned, rate = turned + angle, rate + angle_rate
        pull = work[column, 7] * cosine - work[column, 6] * sine - bend * turned
        second = -drive * pull
        for i in range(6):
            work[column, i] += by[i] * turned + by[6 + i] * rate + by[12 + i] * second


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
def _shift_all(size, count, steps, sections, nodes, work):
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
    work[row, 2] += 1.0
