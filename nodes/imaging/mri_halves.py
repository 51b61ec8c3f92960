"""The mid-sagittal plane of a brain, from its own symmetry, after the idea of [Prima2002]."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32

from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.imaging.parameters import SegmentMriParameters

Affine = Float[np.ndarray, "4 4"]
Normal = Float[np.ndarray, "3"]
Mask = Bool[np.ndarray, "i j k"]
Voxels = Float32[np.ndarray, "i j k"]

ON_PLANE_MM = 0.01  # the plane is found to about this


class Plane(NamedTuple):
    """A plane in the patient frame: all points with `normal @ point_patient_mm == offset_mm`.

    Parameters
    ----------
    normal : (3,) unit vector, towards the patient's left (+x).
    offset_mm : distance of the plane from the frame's zero along the normal.
    """

    normal: Normal
    offset_mm: float


class Content(NamedTuple):
    """What should look the same in a mirror: values, 0 outside of the brain, and some places."""

    values: Voxels
    index_from_patient: Affine
    points_patient_mm: Float[np.ndarray, "n 3"]
    point_values: Float[np.ndarray, " n"]
    centre_patient_mm: Float[np.ndarray, "3"]


def find_midplane(
    values: Voxels, brain: Mask, patient_from_index: Affine, parameters: SegmentMriParameters
) -> Plane:
    """Find the plane in which the brain's mirror image is most like the brain itself.

    Parameters
    ----------
    values : (i, j, k) the brain's intensities, even all over it, on cubic voxels.
    brain : (i, j, k) where the brain is.
    patient_from_index : (4, 4) voxel indices to patient LPS mm.
    parameters : how coarsely to look and how far the head may be turned.

    Returns
    -------
    The plane through the brain that maximises the correlation of values with mirrored values.

    Raises
    ------
    BadInput where the brain is not alike on both sides of any plane.
    """
    from scipy import optimize

    content = _content(values, brain, patient_from_index, parameters.mirror_voxel_mm)

    def unlikeness(turn: Float[np.ndarray, "3"]) -> float:
        return -_mirror_correlation(content, *_plane_of(turn))

    widest = np.deg2rad(parameters.largest_turn_deg)
    angles = np.linspace(-widest, widest, parameters.first_turns)
    starts = [np.array([yaw, roll, 0.0]) for yaw in angles for roll in angles]
    start = min(starts, key=unlikeness)
    spread = np.diag([angles[1] - angles[0], angles[1] - angles[0], parameters.mirror_voxel_mm])
    simplex = np.vstack([start, start + spread / 2])
    options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-7, "maxiter": 400}
    best = optimize.minimize(unlikeness, start, method="Nelder-Mead", options=options)
    if -best.fun < parameters.least_symmetry:
        raise BadInput(
            f"the brain and its mirror image correlate by {-best.fun:.2f} at best",
            f"a brain is alike on both sides: {parameters.least_symmetry:g} or more",
            "check that the image shows a whole brain, or use a label map of your own",
        )
    normal, offset = _plane_of(best.x)
    return Plane(normal, float(offset + normal @ content.centre_patient_mm))


def _plane_of(turn: Float[np.ndarray, "3"]) -> tuple[Normal, float]:
    """Return the normal, turned from +x about z and about y, and the offset from the centre, mm."""
    yaw, roll, offset = turn
    normal = [np.cos(yaw) * np.cos(roll), np.sin(yaw) * np.cos(roll), np.sin(roll)]
    return np.array(normal), float(offset)


def _content(values: Voxels, brain: Mask, patient_from_index: Affine, step_mm: float) -> Content:
    """Smooth, so that folds of the cortex that differ between the halves count less, and thin."""
    from scipy import ndimage

    voxel = float(np.linalg.norm(patient_from_index[:3, 0]))
    step = max(round(step_mm / voxel), 1)
    smooth = ndimage.gaussian_filter(np.where(brain, values, 0), step_mm / voxel / 2)
    thinned = smooth[::step, ::step, ::step]
    coarse = patient_from_index @ np.diag([step, step, step, 1.0])
    places = np.argwhere(brain[::step, ::step, ::step])
    points = transform_points(coarse, places.astype(float))
    return Content(
        np.ascontiguousarray(thinned, np.float32),
        np.linalg.inv(coarse),
        points,
        thinned[tuple(places.T)].astype(float),
        points.mean(axis=0),
    )


def _mirror_correlation(content: Content, normal: Normal, offset_mm: float) -> float:
    """Return Pearson's correlation of the values at points with those at their mirror images.

    Points whose mirror image lies outside of the brain find 0 there, so its shape counts, too.
    """
    from scipy import ndimage

    apart = (content.points_patient_mm - content.centre_patient_mm) @ normal - offset_mm
    mirrored = content.points_patient_mm - 2 * apart[:, None] * normal
    places = transform_points(content.index_from_patient, mirrored)
    found = ndimage.map_coordinates(content.values, places.T, order=1, output=np.float64)
    return float(np.corrcoef(content.point_values, found)[0, 1])


def side_of(
    plane: Plane, shape: tuple[int, ...], patient_from_index: Affine
) -> Float32[np.ndarray, "i j k"]:
    """Return how far each voxel's centre lies to the patient's left of the plane, mm."""
    steps = plane.normal @ patient_from_index[:3, :3]
    first = plane.normal @ patient_from_index[:3, 3] - plane.offset_mm
    i, j, k = np.ogrid[tuple(slice(count) for count in shape)]
    return (steps[0] * i + steps[1] * j + steps[2] * k + first).astype(np.float32)


def left_half(plane: Plane, brain: Mask, patient_from_index: Affine) -> Mask:
    """Return the part of the brain to the patient's left of the plane.

    Of the voxels whose centres lie on the plane one half goes to each side, so that a brain that is
    its own mirror image has halves of one size.
    """
    side_mm = side_of(plane, brain.shape, patient_from_index)
    left = brain & (side_mm > ON_PLANE_MM)
    between = np.flatnonzero(brain & (abs(side_mm) <= ON_PLANE_MM))
    left.flat[between[: len(between) // 2]] = True
    return left
