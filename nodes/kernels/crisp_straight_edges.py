"""Follow straight CRISP robots along edges of their configuration space, sixteen at once.

A polynomial through the last solutions predicts the next one. An edge of which nothing moves but
the offset leads from any wrench, which leaves that offset, to a solution. Lanes share nothing but
the numbers of steps of their rods, which are those of the neediest.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_lanes import absolute, choose, is_any, is_less, load, spread, store
from nodes.kernels.crisp_lanes_vectors import load_vector
from nodes.kernels.crisp_straight_inverse import find_signs, polish_inverse
from nodes.kernels.crisp_straight_newton import guess, solve
from nodes.kernels.crisp_straight_residual import Pose, find_residual, follow_tool
from nodes.kernels.crisp_straight_steps import choose_steps

GROWTH = 1.15  # of a snare's load, after which numbers of steps are measured again
SMALL = 0.1  # a load, in kernels' units, under which a rod needs few steps anyway
CHECKS = 3  # of numbers of steps after one solution; each makes hardly a change to the next
JUMP = 0.5  # of what the wrenches change in a step: further off its guess no solution is trusted
FIRST_JUMP = 2.0  # the same for an only step, whose guess has but one solution to go by
STILL = 0.02  # a change of wrenches, in kernels' units, within which no jump is looked for
RENEWED = 3  # steps after which the Jacobian is computed anew; by trying what is fastest
POINTS = 7  # solutions through which a polynomial predicts the next; more amplify their errors


class Edges(NamedTuple):
    """Edges, one a lane; all arrays have LANES columns.

    turns : (9 n,) rotation of each rod's frame in one step, row by row.
    advances : (n,) growth of each length in one step.
    slides : (k,) growth of each joint's arc length in one step.
    counts : (1,) number of steps; below 0 where a lane has none.
    """

    turns: np.ndarray
    advances: np.ndarray
    slides: np.ndarray
    counts: np.ndarray


class Track(NamedTuple):
    """What is found at each step, the start first; all arrays have LANES columns.

    wrenches : (steps + 1, 6 k) moment and force at each snare's entry.
    tips : (steps + 1, 9) place from the tool's entry, tangent and body's x axis of the tool's tip.
    totals : (steps + 1, 1) how wrong the wrenches are; inf where they lie on another branch, nan
        where the edge was given up before.
    signs : (2, 1) of the Jacobian's determinant at the start, and at the end if that is reached.
    """

    wrenches: np.ndarray
    tips: np.ndarray
    totals: np.ndarray
    signs: np.ndarray


class Rules(NamedTuple):
    """How to follow.

    tolerance : of the residual's magnitude, in the unit of length.
    budget : error of the integration of one rod.
    largest : change of a component of the wrenches in one iteration.
    iterations : at most, at one step.
    renew : steps after which the numbers of steps of rods are measured again.
    exact : whether each iteration has a Jacobian of its own.
    from_rest : whether what is left at the start is kept as offset, and shrinks along the edge.
    """

    tolerance: float
    budget: float
    largest: float
    iterations: int
    renew: int
    exact: bool
    from_rest: bool


@njit(cache=True, nogil=True, error_model="numpy")
def follow_groups(robot, poses, edges, tracks, rules, solver, work):
    """Follow groups of lanes one after the other; arrays as in `follow`, with the group first."""
    steps = np.empty(2 * len(robot.snare), np.int64)
    for group in range(len(poses.lengths)):
        pose = Pose(poses.frames[group], poses.lengths[group], poses.grasps[group])
        edge = Edges(
            edges.turns[group], edges.advances[group], edges.slides[group], edges.counts[group]
        )
        track = Track(
            tracks.wrenches[group], tracks.tips[group], tracks.totals[group], tracks.signs[group]
        )
        solver.offset[:] = 0.0
        follow(robot, pose, edge, track, rules, steps, solver, work)


@njit(cache=True, nogil=True, error_model="numpy")
def follow(robot, pose, edges, track, rules, steps, solver, work):
    """Write the track of each lane until its end, or until a step that finds no solution.

    Parameters
    ----------
    pose : at the edges' start; moved along.
    track : wrenches[0] holds the guess for the start.
    steps : (2 k,) int64, overwritten.
    solver : with offset 0.
    """
    alive = spread(1.0)
    for step in range(len(track.totals)):
        alive = choose(is_less(load(edges.counts, 0), spread(float(step))), spread(0.0), alive)
        if step > 0:
            move_pose(pose, edges)
            _shrink(solver.offset, edges.counts, step)
            _predict(robot, edges, track.wrenches, step, alive)
        wrenches = track.wrenches[step]
        if step % rules.renew == 0:
            solver.checked[:] = wrenches
            alive = alive * choose_steps(robot, pose, wrenches, alive, rules.budget, steps, work)
        if step == 0 and rules.from_rest:
            find_residual(robot, pose, wrenches, solver.offset, steps, work)
        elif step > 0 and step % RENEWED == 0 and not rules.exact:
            polish_inverse(robot, pose, wrenches, steps, solver, work)
        if step == 1 and not rules.from_rest:
            guess(robot, pose, wrenches, alive, rules, steps, solver, work)
        solver.guess[:] = wrenches
        total, wanted = spread(np.inf), alive
        for attempt in range(2):
            exact = rules.exact or step == 0 or attempt == 1
            found = _solve(robot, pose, wrenches, alive, wanted, rules, exact, steps, solver, work)
            total = choose(wanted, found, total)
            wanted = choose(is_less(total, spread(rules.tolerance)), spread(0.0), alive)
            if exact or not is_any(wanted):
                break
            _predict(robot, edges, track.wrenches, step, wanted)
        if step > 0 and not rules.from_rest:
            smooth = _is_smooth(track.wrenches, step, edges.counts, solver.guess)
            total = choose(smooth, total, spread(np.inf))
        store(track.totals[step], 0, choose(alive, total, spread(np.nan)))
        follow_tool(robot, pose, wrenches, True, steps, work)
        track.tips[step][:] = work.tip
        alive = alive * is_less(total, spread(rules.tolerance))
        if step == 0:
            track.signs[0][0, :] = solver.signs
        elif not rules.from_rest:
            _sign_ends(robot, pose, wrenches, edges, step, alive, track, steps, solver, work)
        if not is_any(alive):
            break


@njit(cache=True, nogil=True, error_model="numpy")
def _sign_ends(robot, pose, wrenches, edges, step, alive, track, steps, solver, work):
    """Write the sign of the Jacobian's determinant where lanes reach their ends."""
    is_end = alive * is_less(load(edges.counts, 0), spread(step + 0.5))
    if is_any(is_end):
        signs = track.signs[1][0]
        find_signs(robot, pose, wrenches, is_end, signs, steps, solver, work)


@njit(cache=True, nogil=True, error_model="numpy")
def move_pose(pose, edges):
    """Go one step on."""
    for rod in range(len(pose.lengths)):
        a = load_vector(edges.turns, 9 * rod)
        b = load_vector(edges.turns, 9 * rod + 3)
        c = load_vector(edges.turns, 9 * rod + 6)
        for axis in range(2):
            row = 6 * rod + 3 * axis
            x, y, z = load_vector(pose.frames, row)
            store(pose.frames, row, a[0] * x + a[1] * y + a[2] * z)
            store(pose.frames, row + 1, b[0] * x + b[1] * y + b[2] * z)
            store(pose.frames, row + 2, c[0] * x + c[1] * y + c[2] * z)
        store(pose.lengths, rod, load(pose.lengths, rod) + load(edges.advances, rod))
    for joint in range(len(pose.grasps)):
        store(pose.grasps, joint, load(pose.grasps, joint) + load(edges.slides, joint))


@njit(cache=True, nogil=True, error_model="numpy")
def _is_smooth(wrenches, step, counts, guess):
    """Return lanes, 0 where a solution is far from its guess: it lies on another branch.

    The first of several steps is judged with the second, which has more to go by.
    """
    off, moved = spread(0.0), spread(STILL)
    for row in range(len(guess)):
        now = load(wrenches[step], row)
        off = off + absolute(now - load(guess, row))
        moved = moved + absolute(now - load(wrenches[step - 1], row))
    if step > 1:
        return is_less(off, JUMP * moved)
    is_only = is_less(load(counts, 0), spread(2.0))
    return is_less(off, choose(is_only, FIRST_JUMP * moved, spread(np.inf)))


@njit(cache=True, nogil=True, error_model="numpy")
def _solve(robot, pose, wrenches, alive, wanted, rules, exact, steps, solver, work):
    """Solve wanted lanes, again while needles bend more than their steps were measured for."""
    total = solve(robot, pose, wrenches, wanted, rules, exact, steps, solver, work)
    for _ in range(CHECKS):
        solved = is_less(total, spread(rules.tolerance))
        sure = choose(wanted, solved, alive)
        if not _has_grown(wrenches, sure, solver.checked):
            break
        solver.checked[:] = wrenches
        fine = choose_steps(robot, pose, wrenches, sure, rules.budget, steps, work)
        again = solve(robot, pose, wrenches, wanted * solved, rules, exact, steps, solver, work)
        total = choose(wanted * solved, choose(fine, again, spread(np.inf)), total)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _has_grown(wrenches, alive, checked):
    """Return whether any snare is loaded much more than when its number of steps was measured."""
    for first in range(0, len(wrenches), 6):
        now, before = spread(0.0), spread(SMALL)
        for row in range(first, first + 6):
            now = now + absolute(load(wrenches, row))
            before = before + absolute(load(checked, row))
        if is_any(alive * is_less(GROWTH * before, now)):
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _shrink(offset, counts, step):
    """Take from the offset the share that one step of `counts` takes."""
    left = load(counts, 0) - step
    share = choose(is_less(left, spread(0.0)), spread(0.0), left / (left + 1.0))
    for row in range(len(offset)):
        store(offset, row, load(offset, row) * share)


@njit(cache=True, nogil=True, error_model="numpy")
def _predict(robot, edges, wrenches, step, wanted):
    """Write the first guess of a step in wanted lanes: the polynomial through the last; of the
    first step, wrenches that turn with their needles, which are then turned but hardly bent."""
    now, points = wrenches[step], min(step, POINTS)
    if step == 1:
        for joint in range(len(robot.snare)):
            for first in range(6 * joint, 6 * joint + 6, 3):
                x, y, z = load_vector(wrenches[0], first)
                for axis in range(3):
                    a = load_vector(edges.turns, 9 * robot.snare[joint] + 3 * axis)
                    turned = a[0] * x + a[1] * y + a[2] * z
                    row = first + axis
                    store(now, row, choose(wanted, turned, load(now, row)))
        return
    for row in range(len(now)):
        guess, weight = spread(0.0), float(points)
        for back in range(1, points + 1):
            guess = guess + weight * load(wrenches[step - back], row)
            weight = -weight * (points - back) / (back + 1)
        store(now, row, choose(wanted, guess, load(now, row)))
