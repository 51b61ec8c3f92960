"""A head of ellipsoids as a T1-weighted MRI shows it, with the truth for every voxel."""

from dataclasses import dataclass

import numpy as np

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin

BRAIN = np.array([64.0, 82.0, 66.0])  # half axes, mm
GAP, BONE, SCALP = 2.0, 7.0, 8.0  # thickness of fluid, skull and scalp, mm
CENTRE = np.array([4.0, -9.0, 12.0])
AIR, FAT, DARK_BONE, MARROW, FLUID, GREY, WHITE = 0.0, 190.0, 12.0, 90.0, 28.0, 85.0, 125.0
NAMES = ("head", "skull", "left_brain", "right_brain", "ventricles")


@dataclass(frozen=True)
class Phantom:
    """What to draw.

    Parameters
    ----------
    voxel_mm : edge of the voxels.
    turned : (3, 3) rotation of the head about its centre.
    stripped : nothing but the brain.
    seed : of a noise with standard deviation 4; none without.
    """

    voxel_mm: float = 2.0
    turned: np.ndarray | None = None
    stripped: bool = False
    seed: int | None = None
    ventricles: bool = True


def draw(phantom: Phantom) -> tuple[Volume, LabelMap]:
    """Return the image and the truth at voxel centres."""
    shape = np.rint(np.array([196.0, 232.0, 236.0]) / phantom.voxel_mm).astype(int)
    matrix = np.diag([*[phantom.voxel_mm] * 3, 1.0])
    matrix[:3, 3] = CENTRE - phantom.voxel_mm * (shape - 1) / 2 - [0, 0, 14]
    places = np.stack(np.indices(tuple(shape)), -1) * phantom.voxel_mm + matrix[:3, 3] - CENTRE
    if phantom.turned is not None:
        places = places @ phantom.turned
    values, labels = _paint(places, phantom)
    if phantom.seed is not None:
        values = values + np.random.default_rng(phantom.seed).normal(0, 4, values.shape)
    origin = Origin("head of ellipsoids", simulated=True)
    return (
        Volume(values.astype(np.float32), matrix, "intensity", origin),
        LabelMap(labels, matrix, NAMES, origin),
    )


def _paint(p: np.ndarray, phantom: Phantom) -> tuple[np.ndarray, np.ndarray]:
    values, labels = np.full(p.shape[:3], AIR), np.zeros(p.shape[:3], np.uint8)

    def paint(mask, value, label):
        values[mask] = value
        labels[mask] = label

    def grown(by):
        return _inside(p, BRAIN + by)

    stem = (np.hypot(p[..., 0], p[..., 1] - 5) < 11) & (p[..., 2] < 0) & (p[..., 2] > -80)
    if not phantom.stripped:
        neck = (np.hypot(p[..., 0], p[..., 1] - 5) < 60) & (p[..., 2] < -20)
        paint(grown(GAP + BONE + SCALP) | neck, FAT, 1)
        for side in (-1, 1):
            eye = _inside(p - [30 * side, -84, -38], 12)
            paint(eye & ~grown(GAP + BONE), FLUID, 1)
        paint(grown(GAP + BONE), DARK_BONE, 2)
        paint(grown(GAP + 4.5) & ~grown(GAP + 2.5), MARROW, 2)
        paint(grown(GAP), FLUID, 1)
        canal = (np.hypot(p[..., 0], p[..., 1] - 5) < 16) & (p[..., 2] < 0)
        paint(canal & ~grown(GAP) & (p[..., 2] > -95), FLUID, 1)
    side = np.where(p[..., 0] > 0, 3, 4)
    brain = grown(0) | stem
    paint(brain, GREY, side[brain])
    white = grown(-5)
    paint(white, WHITE, side[white])
    if phantom.ventricles:
        for sign in (-1, 1):
            paint(_inside(p - [13 * sign, 0, 8], [7, 26, 9]), FLUID, 5)
    return values, labels


def _inside(p: np.ndarray, half_axes) -> np.ndarray:
    return ((p / half_axes) ** 2).sum(-1) < 1
