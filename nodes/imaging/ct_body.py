"""The body in a CT: all inside the skin, without the table."""

import numpy as np

from nodes.errors import BadInput
from nodes.geometry.masks import bounding_box, connected_parts, open_planes, plane_holes
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import CtScan, Mask

LONG_AXIS = 2  # of an array along the patient's axes


def find_body(scan: CtScan, parameters: SegmentCtParameters) -> Mask:
    """Return the largest part of tissue, the limbs beside it, and all that they surround.

    Holes are filled within axial planes: the lungs are open to no side there, while in three
    dimensions the trachea leads out at the top.

    Raises
    ------
    BadInput where nothing is as dense as tissue.
    """
    tissue = scan.hu >= parameters.body_threshold_hu
    tissue = open_planes(tissue, LONG_AXIS, parameters.table_opening_mm, scan.spacing)
    parts, sizes = connected_parts(tissue)
    if not len(sizes):
        raise BadInput(
            "no body found in the CT",
            f"body: values at or above {parameters.body_threshold_hu:g} HU",
            "check that the series shows a patient and is in HU",
        )
    place = bounding_box(tissue)
    local, hu = parts[place], scan.hu[place]
    count = len(sizes) + 1
    bright = np.bincount(local[hu >= parameters.bone_threshold_hu], minlength=count)
    mean_hu = np.bincount(local.ravel(), hu.ravel(), count) / np.maximum(np.append(1, sizes), 1)
    # A foot of the table is as large as a limb, but bright all over.
    kept = bright >= scan.voxels(parameters.smallest_limb_bone_ml)
    kept &= mean_hu < parameters.bone_threshold_hu
    kept[sizes.argmax() + 1], kept[0] = True, False
    body = kept[parts]
    return body | plane_holes(body, LONG_AXIS)
