"""A volume made ready for a page: axes nearest to the patient's, few voxels, 8-bit grey."""

import numpy as np
from jaxtyping import Float, Shaped, UInt8

PATIENT_AXES = ("L", "P", "S")


def orient_to_patient(
    voxels: Shaped[np.ndarray, "i j k"], patient_from_index: Float[np.ndarray, "4 4"]
) -> tuple[Shaped[np.ndarray, "l p s"], Float[np.ndarray, "4 4"]]:
    """Permute and flip axes so that i, j, k run as nearly as they can to L, P, S.

    No voxel is resampled: an oblique grid stays oblique.

    Parameters
    ----------
    voxels : (i, j, k) values or labels.
    patient_from_index : (4, 4) voxel indices to patient LPS mm.

    Returns
    -------
    The voxels in the new order and their own (4, 4) transform to patient LPS mm.
    """
    order, signs = match_axes(patient_from_index)
    last = np.array(voxels.shape)[list(order)] - 1
    old_from_new = np.zeros((4, 4))
    old_from_new[3, 3] = 1.0
    for new, (old, sign) in enumerate(zip(order, signs, strict=True)):
        old_from_new[old, new] = sign
        old_from_new[old, 3] = 0.0 if sign > 0 else last[new]
    flips = tuple(slice(None, None, sign) for sign in signs)
    return voxels.transpose(order)[flips], patient_from_index @ old_from_new


def match_axes(
    patient_from_index: Float[np.ndarray, "4 4"],
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return for L, P and S the index axis that lies nearest, and whether it runs along (1, -1)."""
    from scipy.optimize import linear_sum_assignment

    cosines = direction_cosines(patient_from_index)
    _, order = linear_sum_assignment(-np.abs(cosines))
    signs = np.where(cosines[np.arange(3), order] < 0, -1, 1)
    return tuple(order.tolist()), tuple(signs.tolist())


def direction_cosines(patient_from_index: Float[np.ndarray, "4 4"]) -> Float[np.ndarray, "3 3"]:
    """Return the unit vectors of the index axes in the patient frame, as columns."""
    axes = patient_from_index[:3, :3]
    return axes / np.linalg.norm(axes, axis=0)


def tilt_deg(patient_from_index: Float[np.ndarray, "4 4"]) -> float:
    """Return the largest angle in degrees between an axis of an oriented grid and the patient's."""
    cosines = np.clip(np.diag(direction_cosines(patient_from_index)), -1, 1)
    return float(np.degrees(np.arccos(cosines)).max())


def block_size(shape: tuple[int, ...], pixels: int) -> tuple[int, ...]:
    """Return how many voxels along each side become one, so that at most `pixels` remain."""
    return tuple(-(-length // pixels) for length in shape)


def reduced_transform(
    patient_from_index: Float[np.ndarray, "4 4"], block: tuple[int, ...]
) -> Float[np.ndarray, "4 4"]:
    """Return the transform of the grid whose voxels are the centres of the blocks."""
    index_from_reduced = np.diag([*block, 1.0])
    index_from_reduced[:3, 3] = (np.array(block) - 1) / 2
    return patient_from_index @ index_from_reduced


def average_blocks(
    voxels: Shaped[np.ndarray, "i j k"], block: tuple[int, ...]
) -> Float[np.ndarray, "a b c"]:
    """Return the mean of each block; the last voxels repeat where a block is not full."""
    values = np.asarray(voxels, np.float32)
    for axis, size in enumerate(block):
        if size > 1:
            values = average_pairs(values, axis, size)
    return values


def average_pairs(
    values: Float[np.ndarray, "i j k"], axis: int, size: int
) -> Float[np.ndarray, "a b c"]:
    """Return the mean of each `size` neighbours along one axis."""
    count = -(-values.shape[axis] // size)
    total = np.zeros([count if at == axis else n for at, n in enumerate(values.shape)], np.float32)
    for offset in range(size):
        places = np.minimum(np.arange(count) * size + offset, values.shape[axis] - 1)
        total += values.take(places, axis)
    return total / np.float32(size)


def pick_blocks(
    labels: UInt8[np.ndarray, "i j k"], block: tuple[int, ...]
) -> UInt8[np.ndarray, "a b c"]:
    """Return the label in the middle of each block: labels are never mixed."""
    places = [
        np.minimum(np.arange(-(-n // size)) * size + size // 2, n - 1)
        for n, size in zip(labels.shape, block, strict=True)
    ]
    return np.ascontiguousarray(labels[np.ix_(*places)])


def to_grey(
    values: Float[np.ndarray, "a b c"], knots: tuple[float, ...], greys: tuple[float, ...]
) -> UInt8[np.ndarray, "a b c"]:
    """Return values as 8-bit grey along the curve through (knot, grey); what is not a number is 0.

    The curve is read from a table at steps far below one grey: interpolation of every voxel takes
    four times as long.
    """
    steps = 8192
    scale = (steps - 1) / (knots[-1] - knots[0])
    table = np.rint(np.interp(np.linspace(knots[0], knots[-1], steps), knots, greys))
    places = np.nan_to_num((values - np.float32(knots[0])) * np.float32(scale))
    return table.astype(np.uint8)[np.clip(places, 0, steps - 1).astype(np.uint16)]
