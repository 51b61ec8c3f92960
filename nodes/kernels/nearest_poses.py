"""The nearest of many poses of several needles, in a k-d tree that grows with them.

The distance of two configurations is

    d^2 = sum over needles (2 rho min(|q - p|, |q + p|))^2 + (l - l')^2

with unit quaternions q, p, lengths l and a lever rho: q and -q are one rotation, and by an angle a
apart the first term is (4 rho sin(a / 4))^2, about (rho a)^2. Needles do not depend on one another,
so the lesser sign is taken for each, of points as of boxes, and one search suffices. Leaves hold
sixteen points, in lanes, and are halved across the widest side of their box when they are full;
boxes are kept tight [Friedman1977].
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_lanes import LANES, choose, is_any, is_less, load, spread, store
from nodes.kernels.crisp_options import INNER, OUTER

ROWS = 5  # of a needle: quaternion times 2 rho, length
DEEPEST = 16384  # more than how often boxes of doubles can be halved
SAFE = 1 - 1e-12  # of a box's distance, so that its rounding hides no nearer point


class Poses(NamedTuple):
    """A tree; coordinates are scaled so that plain distances count.

    points : (leaf * rows, LANES), with ROWS rows a needle.
    numbers : (leaf, LANES) int64 what was put in.
    filled : (leaf,) int64 how many.
    boxes : (part, 2, rows) least and largest coordinates of all points below.
    parts : (part, 3) int64 children and the coordinate that tells them apart, or -1, leaf, -1.
    splits : (part,) up to which value of it points are the first child's.
    sizes : (2,) int64 parts, leaves.
    ways, bounds : (DEEPEST,) int64 and float64, overwritten: parts yet to be searched, and how far
        their boxes are.
    scratch : (1, LANES), overwritten.
    """

    points: np.ndarray
    numbers: np.ndarray
    filled: np.ndarray
    boxes: np.ndarray
    parts: np.ndarray
    splits: np.ndarray
    sizes: np.ndarray
    ways: np.ndarray
    bounds: np.ndarray
    scratch: np.ndarray


@njit(**OUTER)
def insert_pose(poses, point, number):
    """Put a point in; one that equals all of a full leaf is left out, as it never is the first.

    Parameters
    ----------
    point : (rows,) scaled coordinates; the signs of quaternions may be changed.
    number : larger than all that were put in before.
    """
    if poses.sizes[0] == 0:
        _start(poses, 0, 0)
        poses.sizes[:] = 1
        poses.points[: len(point), 0] = point
    _align(poses.points, point)
    part = 0
    while True:
        _widen(poses.boxes[part], point)
        if poses.parts[part, 0] < 0:
            leaf = poses.parts[part, 1]
            if poses.filled[leaf] < LANES:
                break
            if not _halve(poses, part, leaf, point):
                return
        side = 0 if point[poses.parts[part, 2]] <= poses.splits[part] else 1
        part = poses.parts[part, side]
    rows, lane = len(point), poses.filled[leaf]
    for row in range(rows):
        poses.points[leaf * rows + row, lane] = point[row]
    poses.numbers[leaf, lane] = number
    poses.filled[leaf] += 1


@njit(**INNER)
def _align(points, point):
    """Choose the sign of each quaternion that is nearer to that of the very first point."""
    for needle in range(0, len(point), ROWS):
        total = 0.0
        for axis in range(4):
            total += points[needle + axis, 0] * point[needle + axis]
        if total < 0.0:
            for axis in range(4):
                point[needle + axis] = -point[needle + axis]


@njit(**INNER)
def _start(poses, part, leaf):
    """Make an empty leaf."""
    poses.parts[part, 0], poses.parts[part, 1], poses.parts[part, 2] = -1, leaf, -1
    poses.filled[leaf] = 0
    poses.boxes[part, 0, :], poses.boxes[part, 1, :] = np.inf, -np.inf


@njit(**INNER)
def _widen(box, point):
    for row in range(len(point)):
        box[0, row] = min(box[0, row], point[row])
        box[1, row] = max(box[1, row], point[row])


@njit(**INNER)
def _halve(poses, part, leaf, point):
    """Share a full leaf's points out to two, and return whether they and a further one differ."""
    rows = poses.boxes.shape[2]
    low, high, widest = 0.0, 0.0, -1
    for row in range(rows):
        least = greatest = point[row]
        for lane in range(LANES):
            value = poses.points[leaf * rows + row, lane]
            least, greatest = min(least, value), max(greatest, value)
        if greatest - least > high - low:
            low, high, widest = least, greatest, row
    if widest < 0:
        return False
    middle = low + 0.5 * (high - low)
    poses.splits[part] = middle if middle < high else low
    first, second, other = poses.sizes[0], poses.sizes[0] + 1, poses.sizes[1]
    poses.sizes[0] += 2
    poses.sizes[1] += 1
    poses.parts[part, 0], poses.parts[part, 1], poses.parts[part, 2] = first, second, widest
    _start(poses, first, leaf)
    _start(poses, second, other)
    for lane in range(LANES):
        is_first = poses.points[leaf * rows + widest, lane] <= poses.splits[part]
        goal, below = (leaf, first) if is_first else (other, second)
        place = poses.filled[goal]
        for row in range(rows):
            value = poses.points[leaf * rows + row, lane]
            poses.points[goal * rows + row, place] = value
            poses.boxes[below, 0, row] = min(poses.boxes[below, 0, row], value)
            poses.boxes[below, 1, row] = max(poses.boxes[below, 1, row], value)
        poses.numbers[goal, place] = poses.numbers[leaf, lane]
        poses.filled[goal] += 1
    return True


@njit(**OUTER)
def nearest_pose(poses, point):
    """Return number and squared distance of the nearest point; of equally near ones the first.

    Parameters
    ----------
    poses : with one point at least.
    point : (rows,) scaled coordinates.
    """
    best, found, waiting, part = np.inf, -1, 0, 0
    while True:
        while poses.parts[part, 0] >= 0:
            near, far = poses.parts[part, 0], poses.parts[part, 1]
            gap, other = _find_gap(poses.boxes, near, point), _find_gap(poses.boxes, far, point)
            if other < gap:
                near, far, gap, other = far, near, other, gap
            if other <= best:
                poses.ways[waiting], poses.bounds[waiting] = far, other
                waiting += 1
            part = near
            if gap > best:
                break
        if poses.parts[part, 0] < 0:
            best, found = _search_leaf(poses, poses.parts[part, 1], point, best, found)
        while waiting > 0 and poses.bounds[waiting - 1] > best:
            waiting -= 1
        if waiting == 0:
            return found, best
        waiting -= 1
        part = poses.ways[waiting]


@njit(**INNER)
def _find_gap(boxes, part, point):
    """Return the squared distance to a box, a little less for rounding."""
    total = 0.0
    for needle in range(0, len(point), ROWS):
        same = opposite = 0.0
        for row in range(needle, needle + 4):
            low, high, x = boxes[part, 0, row], boxes[part, 1, row], point[row]
            gap = max(low - x, x - high, 0.0)
            same += gap * gap
            gap = max(low + x, -x - high, 0.0)
            opposite += gap * gap
        row = needle + 4
        gap = max(boxes[part, 0, row] - point[row], point[row] - boxes[part, 1, row], 0.0)
        total += min(same, opposite) + gap * gap
    return SAFE * total


@njit(**INNER)
def _search_leaf(poses, leaf, point, best, found):
    """Return the least squared distance, of before or of a leaf's points, and its number."""
    rows, total = len(point), spread(0.0)
    for needle in range(0, rows, ROWS):
        same, opposite = spread(0.0), spread(0.0)
        for row in range(needle, needle + 4):
            value = load(poses.points, leaf * rows + row)
            gap, sum_ = value - point[row], value + point[row]
            same, opposite = same + gap * gap, opposite + sum_ * sum_
        gap = load(poses.points, leaf * rows + needle + 4) - point[needle + 4]
        total = total + choose(is_less(same, opposite), same, opposite) + gap * gap
    if not is_any(1.0 - is_less(spread(best), total)):
        return best, found
    store(poses.scratch, 0, total)
    for lane in range(poses.filled[leaf]):
        distance, number = poses.scratch[0, lane], poses.numbers[leaf, lane]
        if distance < best or (distance == best and number < found):
            best, found = distance, number
    return best, found
