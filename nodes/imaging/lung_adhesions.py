"""Strands of tissue between a collapsed lung and the chest wall."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.frames import transform_points
from nodes.geometry.grids import spacing_mm
from nodes.geometry.masks import Mask
from nodes.imaging.lung_deformation import Affine, Vector, around_segment
from nodes.imaging.parameters import CollapseLungParameters

TRIALS = 400  # directions
STEP_MM, FARTHEST_MM = 1.0, 300.0  # along a direction
SHORTEST_MM, APART_MM = 6.0, 16.0  # length of a strand, and distance between their ends


@dataclass(frozen=True)
class Parts:
    """Lung and cavity on one grid, where strands are looked for.

    Parameters
    ----------
    lung, cavity : (i, j, k) collapsed lung, and what it left.
    patient_from_index : (4, 4) their indices to patient LPS mm.
    side : 1 left, -1 right.
    """

    lung: Mask
    cavity: Mask
    patient_from_index: Affine
    side: int


def draw_adhesions(
    parts: Parts, parameters: CollapseLungParameters, chance: np.random.Generator
) -> tuple[Mask, int]:
    """Return the strands' voxels, and how many strands they are: fewer where gaps are too small.

    A strand is at least as wide as a voxel's diagonal, so that it is in one piece.
    """
    strands = np.zeros_like(parts.cavity)
    diagonal = float(np.linalg.norm(spacing_mm(parts.patient_from_index)))
    width_mm = max(parameters.adhesion_width_mm, diagonal)
    lines = _lines(parts, chance)[: parameters.adhesions]
    for start, end in lines:
        _draw(strands, parts, start, end, width_mm / 2)
    return strands & parts.cavity, len(lines)


def _lines(parts: Parts, chance: np.random.Generator) -> list[tuple[Vector, Vector]]:
    """Return lines from the lung outwards to the wall, in random order and apart."""
    inside = np.argwhere(parts.lung[::3, ::3, ::3]) * 3.0
    middle = transform_points(parts.patient_from_index, inside).mean(axis=0)
    directions = chance.normal(size=(TRIALS, 3))
    directions[:, 0] = parts.side * abs(directions[:, 0])  # the chest wall, not the mediastinum
    directions[:, 2] *= 0.5  # not the diaphragm
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    steps = np.arange(0, FARTHEST_MM, STEP_MM)[:, None]
    lines: list[tuple[Vector, Vector]] = []
    for direction in directions:
        line = _last_gap(parts, middle + steps * direction)
        if line and all(np.linalg.norm(line[1] - other[1]) > APART_MM for other in lines):
            lines.append(line)
    return lines


def _last_gap(parts: Parts, points: Float[np.ndarray, "n 3"]) -> tuple[Vector, Vector] | None:
    """Return where a ray leaves the lung for the last time, and then the cavity."""
    places = np.rint(transform_points(np.linalg.inv(parts.patient_from_index), points)).astype(int)
    on_grid = ((places >= 0) & (places < parts.lung.shape)).all(axis=1)
    places, points = places[on_grid], points[on_grid]
    i, j, k = places.T
    in_lung, in_cavity = parts.lung[i, j, k], parts.cavity[i, j, k]
    if not in_lung.any():
        return None
    start = int(np.flatnonzero(in_lung)[-1])
    free = in_cavity[start + 1 :]
    gap = len(free) if free.all() else int(np.argmin(free))
    if gap * STEP_MM < SHORTEST_MM or start + 1 + gap >= len(points):
        return None
    return points[start], points[start + 1 + gap]


def _draw(strands: Mask, parts: Parts, start: Vector, end: Vector, radius_mm: float) -> None:
    """Mark the voxels of one strand, rooted a radius deep at both ends."""
    deeper = (end - start) / np.linalg.norm(end - start) * radius_mm
    ends = (start - deeper, end + deeper)
    window, away = around_segment(parts.patient_from_index, strands.shape, ends, radius_mm)
    strands[window] |= away <= radius_mm
