"""Made grids with cameras in hard places: on corners, edges, faces and centres of cells."""

import numpy as np
from hypothesis import strategies as st

from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin

FREE, BOUNDARY = 1, 2
PLACES = (0.0, 0.5, -0.5, 0.25, 2.0**-16, 0.5 - 2.0**-16, 0.3)  # within a cell


def to_grid(free, patient_from_index=None, corners=False):
    """Return the occupancy grid of a free space, its boundary by faces or by corners, too."""
    labels, padded = free.astype(np.uint8), np.pad(free, 1)
    near = np.zeros(free.shape, bool)
    for shift in np.ndindex(3, 3, 3):
        if corners or np.abs(np.array(shift) - 1).sum() == 1:
            near |= padded[tuple(slice(s, s + n) for s, n in zip(shift, free.shape, strict=True))]
    labels[near & ~free] = BOUNDARY
    matrix = np.eye(4) if patient_from_index is None else patient_from_index
    return LabelMap(labels, matrix, ("free", "boundary"), Origin("a made cavity", True, ("n",)))


def ellipsoid(halves):
    """Return the cells of a grid whose centres are in an ellipsoid."""
    shape = [2 * int(half) + 3 for half in halves]
    middle = (np.array(shape) - 1) / 2
    offsets = (np.stack(np.indices(shape), axis=-1) - middle) / halves
    return (offsets**2).sum(axis=-1) <= 1


@st.composite
def seeded_grids(draw):
    """Draw free spaces, loosely filled or of thin walls, and a generator for the rest."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    shape = draw(st.tuples(*[st.integers(2, 14)] * 3))
    density = draw(st.sampled_from([0.5, 0.8, 0.95, 0.995]))
    free = rng.random(shape) < density
    if draw(st.booleans()):
        free[rng.integers(shape[0])] = False
    return free, rng


def hard_cameras(rng, shape, count):
    """Return places in index coordinates, most of them such that rays meet edges, and views."""
    cells = rng.integers(0, shape, (count, 3))
    cameras = cells + rng.choice(PLACES, (count, 3))
    straight = rng.integers(-1, 2, (count, 3)).astype(float)
    straight[~straight.any(axis=1)] = 1.0
    views = np.where(rng.random((count, 1)) < 0.5, straight, rng.normal(size=(count, 3)))
    return cameras, views
