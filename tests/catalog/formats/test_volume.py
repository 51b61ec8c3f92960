"""Volumes come back as they were, and SimpleITK sees every voxel at the same patient position."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.volume import VolumeFormat
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from tests.catalog.formats.hostile import ORIGINS, affines, assert_same, voxels

UNITS = st.sampled_from(["HU", "intensity", "mm"])
VOLUMES = st.builds(
    Volume, st.sampled_from(["int16", "float32"]).flatmap(voxels), affines(), UNITS, ORIGINS
)
OBLIQUE = np.array(
    [[0.6, -0.8, 0.1, -81.25], [0.75, 0.5, -0.2, 1 / 3], [0.05, 0.3, 2.4, 1e-7], [0, 0, 0, 1]]
)


@settings(max_examples=60, deadline=None)
@given(VOLUMES)
def test_every_field_of_a_volume_comes_back(volume: Volume) -> None:
    back = VolumeFormat.decode(VolumeFormat.encode(volume))
    assert_same(back.voxels, volume.voxels)
    assert_same(back.patient_from_index, volume.patient_from_index)
    assert (back.unit, back.origin) == (volume.unit, volume.origin)


@pytest.mark.parametrize("order", ["C", "F"])
def test_memory_layout_changes_nothing(order: str) -> None:
    numbers = np.arange(24, dtype="int16").reshape(2, 3, 4)
    laid = np.asarray(numbers, order=order)
    one, two = (Volume(v, np.eye(4), "HU", Origin("x")) for v in (laid, numbers))
    assert VolumeFormat.encode(one) == VolumeFormat.encode(two)


@settings(max_examples=15, deadline=None)
@given(affines(), voxels("int16"))
def test_simpleitk_reads_values_and_positions(
    tmp_path_factory: pytest.TempPathFactory, affine: np.ndarray, values: np.ndarray
) -> None:
    check_with_itk(tmp_path_factory.mktemp("itk"), values, affine)


def test_simpleitk_reads_a_hand_made_oblique_grid(tmp_path: Path) -> None:
    directions = OBLIQUE[:3, :3]
    turned, _ = np.linalg.qr(directions)
    affine = OBLIQUE.copy()
    affine[:3, :3] = turned * [0.7, 0.9, 2.5]
    check_with_itk(tmp_path, np.arange(60, dtype="int16").reshape(3, 4, 5), affine)


def check_with_itk(folder: Path, values: np.ndarray, affine: np.ndarray) -> None:
    import SimpleITK as sitk

    (content,) = VolumeFormat.encode(Volume(values, affine, "HU", Origin("x"))).values()
    (folder / "volume.nrrd").write_bytes(content)
    image = sitk.ReadImage(str(folder / "volume.nrrd"))
    assert image.GetSize() == values.shape
    for index in {(0, 0, 0), tuple(n - 1 for n in values.shape), (values.shape[0] - 1, 0, 0)}:
        expected = [sum(affine[r, c] * index[c] for c in range(3)) + affine[r, 3] for r in range(3)]
        place = image.TransformIndexToPhysicalPoint([int(i) for i in index])
        assert place == pytest.approx(expected, abs=1e-4)
        assert image.GetPixel([int(i) for i in index]) == values[index]
