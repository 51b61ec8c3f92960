"""Stiffness of pieces of rods and of relaxed joints, as six by six matrices (force, moment) by
(dp, rotation vector), and what is left of it when places between are eliminated."""

from numba import njit

from nodes.kernels.crisp_linear import factorise, solve_factorised
from nodes.kernels.crisp_options import INNER


@njit(**INNER)
def invert_derivative(state, slack, triangles, order, column, inverse):
    """Write the inverse of the derivative of the piece's end by the wrench at its start.

    slack : by which a newton lengthens or shears the piece, mm / N.
    """
    for i in range(6):
        for j in range(6):
            triangles[i, j] = state[12 + 6 * i + j] + (slack if j == i + 3 else 0.0)
    factorise(triangles, order)
    for j in range(6):
        for i in range(6):
            column[i] = 1.0 if i == j else 0.0
        solve_factorised(triangles, order, column)
        for i in range(6):
            inverse[i, j] = column[i]


@njit(**INNER)
def piece_stiffness(way, moment, force, inverse, large):
    """Write the stiffness of the piece just bent, start then end, (force, moment) by (dp, phi).

    way, moment, force : from start to end, and the wrench at the start.
    inverse : of the derivative G of the end's pose by the wrench at the start.
    """
    for j in range(3):  # columns phi of G T, by which the rigid motion of the start is taken off
        a, b = (j + 1) % 3, (j + 2) % 3
        for i in range(6):
            row = (i + 3) % 6
            large[row, j] = inverse[i, j]
            turned = -inverse[i, a] * way[b] + inverse[i, b] * way[a]
            large[row, 3 + j] = inverse[i, 3 + j] + turned
        large[a, 3 + j] += force[b]
        large[b, 3 + j] -= force[a]
        large[3 + a, 3 + j] += moment[b]
        large[3 + b, 3 + j] -= moment[a]
    for j in range(6):
        for i in range(6):
            large[(i + 3) % 6, 6 + j] = -inverse[i, j]
            large[6 + (i + 3) % 6, 6 + j] = inverse[i, j]
        for i in range(3):  # dm at the end = dm - dp x n - way x dn
            a, b = (i + 1) % 3, (i + 2) % 3
            large[9 + i, 6 + j] -= way[a] * inverse[3 + b, j] - way[b] * inverse[3 + a, j]
    for j in range(3):
        a, b = (j + 1) % 3, (j + 2) % 3
        large[9 + a, 6 + j] += force[b]
        large[9 + b, 6 + j] -= force[a]


@njit(**INNER)
def make_symmetric(large):
    """Take off what is not symmetric in a piece's stiffness, phi x m / 2, which does no work."""
    for i in range(6):
        for j in range(6):
            large[6 + i, j] = large[j, 6 + i]
        for j in range(i):
            for k in (0, 6):
                mean = 0.5 * (large[k + i, k + j] + large[k + j, k + i])
                large[k + i, k + j], large[k + j, k + i] = mean, mean


@njit(**INNER)
def turn_stiffness(stiff, turn, room):
    """Turn a stiffness into axes of which `turn` has the directions in its columns."""
    for i in range(6):
        for half in (0, 3):
            for j in range(3):
                total = 0.0
                for k in range(3):
                    total += stiff[i, half + k] * turn[k, j]
                room[i, half + j] = total
    for j in range(6):
        for half in (0, 3):
            for i in range(3):
                total = 0.0
                for k in range(3):
                    total += turn[k, i] * room[half + k, j]
                stiff[half + i, j] = total


@njit(**INNER)
def free_turns(snare, moment, stiff, large):
    """Let a relaxed snare's tip turn about the two tangents, the tool's being z of the axes.

    These two turns, unknowns 0 and 1, are eliminated; what the tool then feels replaces `stiff`.

    snare : (3,) its tangent.
    """
    tool = (0.0, 0.0, 1.0)
    for i in range(6):
        large[0, 2 + i], large[1, 2 + i] = stiff[5, i], 0.0
        for j in range(3):
            large[1, 2 + i] += snare[j] * stiff[3 + j, i]
        large[2 + i, 0], large[2 + i, 1] = large[0, 2 + i], large[1, 2 + i]
        for j in range(6):
            large[2 + i, 2 + j] = stiff[i, j]
    for i in range(2):
        large[i, 0], large[i, 1] = large[i, 7], 0.0
        for j in range(3):
            large[i, 1] += large[i, 5 + j] * snare[j]
    _add_curvature(tool, snare, moment, large)
    found = eliminate(large, 8, 2)
    for i in range(6):
        for j in range(6):
            stiff[i, j] = large[2 + i, 2 + j]
    return found


@njit(**INNER)
def _add_curvature(t, k, moment, large):
    """Add the second variation of t . k, times its multiplier, where phi_snare = phi + a t + b k.

    The multiplier mu is that of m_k = mu t x k. For turns of the tool phi and of the snare psi it
    is phi . A phi + psi . A psi + 2 phi . B psi with A = (t k^T + k t^T) / 2 - c, B = c - k t^T,
    c = t . k; what is of phi alone cancels, as for any turn of both.
    """
    c = t[0] * k[0] + t[1] * k[1] + t[2] * k[2]
    multiplier = 0.0
    for i in range(3):
        p, q = (i + 1) % 3, (i + 2) % 3
        multiplier += moment[i] * (t[p] * k[q] - t[q] * k[p]) / (1 - c * c)
    for i in range(3):  # (A + B) t = (t c - k) / 2 and (A + B) k = (t - k c) / 2
        by_t, by_k = 0.5 * multiplier * (c * t[i] - k[i]), 0.5 * multiplier * (t[i] - c * k[i])
        large[5 + i, 0] += by_t
        large[0, 5 + i] += by_t
        large[5 + i, 1] += by_k
        large[1, 5 + i] += by_k
    # t . A t = k . A k = 0, and t . A k = (1 - c^2) / 2
    large[0, 1] += 0.5 * multiplier * (1 - c * c)
    large[1, 0] += 0.5 * multiplier * (1 - c * c)


@njit(**INNER)
def eliminate(matrix, size, count):
    """Eliminate the first `count` unknowns of a symmetric matrix; return the negative pivots.

    The stiffness of those that are left ends in the last rows and columns.
    """
    found = 0
    for k in range(count):
        pivot = matrix[k, k]
        if pivot < 0:
            found += 1
        for i in range(k + 1, size):
            share = matrix[i, k] / pivot
            for j in range(k + 1, size):
                matrix[i, j] -= share * matrix[k, j]
    return found
