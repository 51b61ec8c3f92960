"""Adhesions of the phantom: bands of tissue through the fluid, from the lung to the chest wall."""

import numpy as np
from jaxtyping import Float

from nodes.imaging.painting import Canvas, paint
from nodes.imaging.solids import Solid, tube
from nodes.imaging.thorax_anatomy import ADHESION, EFFUSION, SOFT

Line = tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]

WIDTHS, SHORTEST = (2.0, 6.0), 5.0  # mm
TRIALS, APART = 300, 16.0  # directions tried, and how far apart bands end, mm
STEP, FARTHEST, ROOTED = 1.0, 260.0, 3.0  # along a direction, and how deep a band goes in, mm


def paint_adhesions(
    canvas: Canvas, lung: Solid, cavity: Solid, count: int, side: int, chance: np.random.Generator
) -> None:
    """Paint bands; fewer, where there is not so much fluid.

    A band is at least as wide as a voxel's diagonal, so that it is in one piece.
    """
    thinnest = float(np.linalg.norm(canvas.spacing))
    for start, end in _gaps(lung, cavity, side, chance)[:count]:
        width = max(chance.uniform(*WIDTHS), thinnest)
        along = (end - start) / np.linalg.norm(end - start)
        course = np.stack([start - ROOTED * along, (start + end) / 2, end + ROOTED * along])
        course[1] += chance.normal(size=3)  # a band is not quite straight
        paint(canvas, tube(course, width / 2), SOFT, ADHESION, (EFFUSION,))


def _gaps(lung: Solid, cavity: Solid, side: int, chance: np.random.Generator) -> list[Line]:
    """Return lines from lung to chest wall, in random order and apart from each other."""
    middle = (np.array(lung.low) + lung.high) / 2
    directions = chance.normal(size=(TRIALS, 3))
    directions[:, 0] = side * abs(directions[:, 0])  # to the chest wall, not the mediastinum
    directions[:, 2] *= 0.6  # and not the diaphragm
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    steps = np.arange(0, FARTHEST, STEP)
    lines: list[Line] = []
    for direction in directions:
        points = middle + steps[:, None] * direction
        line = _last_gap(_inside(lung, points), _inside(cavity, points), points)
        if line and all(np.linalg.norm(line[1] - other[1]) > APART for other in lines):
            lines.append(line)
    return lines


def _last_gap(in_lung: np.ndarray, in_cavity: np.ndarray, points: np.ndarray) -> Line | None:
    """Return where a ray leaves the lung for the last time and then the cavity, if far apart."""
    if not in_lung.any():
        return None
    start = int(np.flatnonzero(in_lung)[-1])
    end = start + int(np.argmin(in_cavity[start:]))
    far = (end - start) * STEP >= SHORTEST
    return (points[start], points[end]) if far else None


def _inside(solid: Solid, points: Float[np.ndarray, "n 3"]) -> np.ndarray:
    x, y, z = points.T.astype(np.float32)[:, :, None, None]
    return solid.distance((x, y, z)).ravel() < 0
