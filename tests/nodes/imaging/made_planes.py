"""Made-up planes of a scan, for tests of the reader."""

from pathlib import Path

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from nodes.imaging.artefacts import ImageFiles, Slice
from nodes.imaging.parameters import ReadVolumeParameters
from nodes.imaging.read_volume import read_volume

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters" / "read_volume.yml"
VALUES = yaml.safe_load(DEFAULTS.read_text())
PARAMETERS = ReadVolumeParameters(**VALUES)


def settings_of(**changed):
    return ReadVolumeParameters(**{**VALUES, **changed})


def read(planes, **changed):
    return read_volume(ImageFiles(tuple(planes)), settings_of(**changed))


def linear_field(points):
    """Values that tell every place apart."""
    return points @ [1.0, 2.0, 4.0] - 500


def stack(
    heights,
    field=linear_field,
    axes=None,
    lean=(0.0, 0.0),
    shape=(4, 6),
    spacing=(0.5, 0.8),
    centre=(0.0, 0.0, 0.0),
    **about,
):
    """Planes at these heights along a normal, of a field of patient coordinates.

    lean : shift within the plane for each mm of height. centre : of the plane at height 0.
    """
    axes = Rotation.random(rng=np.random.default_rng(0)).as_matrix() if axes is None else axes
    rows, columns = np.indices(shape)
    pixel = np.stack([columns, rows, 0 * rows, 1 + 0 * rows], axis=-1)
    middle = np.array([spacing[0] * (shape[1] - 1) / 2, spacing[1] * (shape[0] - 1) / 2, 0])
    about = {"series": 1, "modality": "CT", "unit": "HU", **about}
    planes = []
    for height in heights:
        matrix = np.eye(4)
        matrix[:3, :3] = axes * [*spacing, 1.0]
        offset = np.array([lean[0] * height, lean[1] * height, height])
        matrix[:3, 3] = np.asarray(centre) + axes @ (offset - middle)
        values = field((pixel @ matrix.T)[..., :3]).astype(np.float32)
        planes.append(Slice(values, matrix, **about))
    return planes


def places(volume):
    """Patient coordinates of all voxels, (n, 3), in the order of voxels.ravel()."""
    index = np.indices(volume.voxels.shape).reshape(3, -1)
    return (volume.patient_from_index @ np.vstack([index, np.ones(index.shape[1])]))[:3].T
