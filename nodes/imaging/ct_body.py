"""The body in a CT: all inside the skin, without the table."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.errors import BadInput
from nodes.geometry.masks import bounding_box, connected_parts, open_planes, plane_holes
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import CtScan, Mask

LONG_AXIS = 2  # of an array along the patient's axes
Plane = Bool[np.ndarray, "x y"]


def find_body(scan: CtScan, parameters: SegmentCtParameters) -> Mask:
    """Return the largest part of tissue, the limbs beside it, and all that they surround.

    A table that lies close to the body is cut off along its top, where that is straight. Holes are
    filled within axial planes: the lungs are open to no side there, while in three dimensions the
    trachea leads out at the top.

    Raises
    ------
    BadInput where nothing is as dense as tissue.
    """
    tissue = scan.hu >= parameters.body_threshold_hu
    tissue = open_planes(tissue, LONG_AXIS, parameters.table_opening_mm, scan.spacing)
    if not tissue.any():
        raise BadInput(
            "no body found in the CT",
            f"body: values at or above {parameters.body_threshold_hu:g} HU",
            "check that the series shows a patient and is in HU",
        )
    body = _trunk_and_limbs(scan, tissue, parameters)
    table = _table(scan, body, parameters)
    if table.any():
        body = _trunk_and_limbs(scan, body & ~table[:, :, None], parameters)
    return body | plane_holes(body, LONG_AXIS)


def table_notices(scan: CtScan, body: Mask, parameters: SegmentCtParameters) -> tuple[str, ...]:
    """Return what a reader must know where the body may still hold the table.

    A table's side is the same in all slices, which no flank is: there the top of what is in most
    slices and that of what is in few agree.
    """
    most = _columns(body, parameters.table_slices_share)
    few = _columns(body, 1 - parameters.table_slices_share)
    for posterior in (True, False):
        tops, other = _tops(most, posterior), _tops(few, posterior)
        for side in _sides(tops, scan, parameters):
            if _agree(tops[side], other[side], scan, parameters):
                return (
                    "an edge of the body is the same in all slices: the body may hold the table,"
                    " whose underside then counts as skin",
                )
    return ()


def _trunk_and_limbs(scan: CtScan, tissue: Mask, parameters: SegmentCtParameters) -> Mask:
    """Return the largest part and those that hold a limb's bone."""
    parts, sizes = connected_parts(tissue)
    place = bounding_box(tissue)
    local, hu = parts[place], scan.hu[place]
    count = len(sizes) + 1
    bright = np.bincount(local[hu >= parameters.bone_threshold_hu], minlength=count)
    mean_hu = np.bincount(local.ravel(), hu.ravel(), count) / np.maximum(np.append(1, sizes), 1)
    # A foot of the table is as large as a limb, but bright all over.
    kept = bright >= scan.voxels(parameters.smallest_limb_bone_ml)
    kept &= mean_hu < parameters.bone_threshold_hu
    kept[sizes.argmax() + 1], kept[0] = True, False
    return kept[parts]


def _table(scan: CtScan, body: Mask, parameters: SegmentCtParameters) -> Plane:
    """Return the part of the axial plane from a table's top on, in all slices; or nothing.

    A table is told by a top that runs straight on from one side of the body to the other in most
    slices.
    """
    most = _columns(body, parameters.table_slices_share)
    rows = np.arange(body.shape[1])
    for posterior in (True, False):
        tops = _tops(most, posterior)
        sides = _sides(tops, scan, parameters)
        line = _line(tops, sides)
        if sides and all(_agree(tops[side], line[side], scan, parameters) for side in sides):
            line = np.rint(line)[:, None]
            table = rows >= line if posterior else rows <= line
            if _is_no_loss(body & table[:, :, None], body, scan, parameters):
                return table
    return np.zeros(most.shape, bool)


def _is_no_loss(cut: Mask, body: Mask, scan: CtScan, parameters: SegmentCtParameters) -> bool:
    """Whether what would be cut off holds no bone and less than what would be left."""
    bright = np.count_nonzero(cut & (scan.hu >= parameters.bone_threshold_hu))
    few = bright < scan.voxels(parameters.smallest_limb_bone_ml)
    return bool(few and 2 * np.count_nonzero(cut) < np.count_nonzero(body))


def _columns(body: Mask, share: float) -> Plane:
    """Return where the axial plane is body in at least this share of the body's slices."""
    slices = body.any(axis=(0, 1))
    return body.sum(axis=LONG_AXIS) >= share * slices.sum()


def _tops(plane: Plane, posterior: bool) -> Float[np.ndarray, " x"]:
    """Return in which row the part of each column ends that lies nearest to the table's side of
    the image; NaN where a column is empty."""
    plane = plane[:, ::-1] if posterior else plane
    height = plane.shape[1]
    first = plane.argmax(axis=1)
    gap = ~plane & (np.arange(height) > first[:, None])
    last = np.where(gap.any(axis=1), gap.argmax(axis=1), height) - 1.0
    return np.where(plane.any(axis=1), height - 1 - last if posterior else last, np.nan)


def _sides(
    tops: Float[np.ndarray, " x"], scan: CtScan, parameters: SegmentCtParameters
) -> list[Int[np.ndarray, " n"]]:
    """Return the outermost columns on either side, as wide as a table's edge; none if too few."""
    places = np.flatnonzero(np.isfinite(tops))
    wide = round(parameters.table_edge_mm / float(scan.spacing[0]))
    return [places[:wide], places[-wide:]] if 0 < 2 * wide < len(places) else []


def _line(
    tops: Float[np.ndarray, " x"], sides: list[Int[np.ndarray, " n"]]
) -> Float[np.ndarray, " x"]:
    """Return the straight line through the middles of the sides, in each column."""
    if not sides:
        return tops
    x = [float(np.median(side)) for side in sides]
    y = [float(np.median(tops[side])) for side in sides]
    return y[0] + (np.arange(len(tops)) - x[0]) * (y[1] - y[0]) / (x[1] - x[0])


def _agree(
    one: Float[np.ndarray, " n"],
    other: Float[np.ndarray, " n"],
    scan: CtScan,
    parameters: SegmentCtParameters,
) -> bool:
    """Whether rows are the same, as nearly as voxels go, in most columns of a side."""
    limit = max(parameters.table_straightness_mm / float(scan.spacing[1]), 1.0)
    return bool(np.mean(abs(one - other) <= limit) >= parameters.table_slices_share)
