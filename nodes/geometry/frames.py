"""The coordinate frames of the project and how their names compose.

`a_from_b` is a 4 x 4 matrix that maps homogeneous column vectors in frame b to frame a, so names
cancel: `patient_from_tip = patient_from_base @ base_from_tip`. Points name frame and unit:
`points_patient_mm`.

======= ========================================================== =====
frame   axes                                                       unit
======= ========================================================== =====
patient LPS: +x to the patient's left, +y posterior, +z superior   mm
        (as DICOM PS3.3 C.7.6.2.1.1 and ITK have it)
index   voxel indices (i, j, k), whole numbers at voxel centres    -
camera  +x right, +y down, +z forward                              mm
sfm     structure from motion, before it is scaled                 none
base    a robot's base                                             mm
tip     a robot's tip                                              mm
entry   a tube's entry point, +z along the tube                    mm
======= ========================================================== =====
"""

import numpy as np
from jaxtyping import Float


def transform_points(
    a_from_b: Float[np.ndarray, "4 4"], points_b: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3"]:
    """Map points from frame b to frame a.

    Parameters
    ----------
    a_from_b : (4, 4) rigid or affine transform.
    points_b : (n, 3) points in frame b.

    Returns
    -------
    (n, 3) the same points in frame a.
    """
    return points_b @ a_from_b[:3, :3].T + a_from_b[:3, 3]
