"""Label maps come back as they were, and their header says what 3D Slicer looks for."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.labelmap import LabelMapFormat
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from tests.catalog.formats.hostile import ORIGINS, TEXTS, affines, assert_same, voxels

LABEL_MAPS = st.builds(
    LabelMap, voxels("uint8"), affines(), st.lists(TEXTS, max_size=4).map(tuple), ORIGINS
)


@settings(max_examples=60, deadline=None)
@given(LABEL_MAPS)
def test_every_field_of_a_label_map_comes_back(label_map: LabelMap) -> None:
    back = LabelMapFormat.decode(LabelMapFormat.encode(label_map))
    assert_same(back.voxels, label_map.voxels)
    assert_same(back.patient_from_index, label_map.patient_from_index)
    assert (back.names, back.origin) == (label_map.names, label_map.origin)


def test_more_than_a_hundred_labels_keep_their_order() -> None:
    names = tuple(f"label {n}" for n in range(255))
    label_map = LabelMap(np.zeros((2, 2, 2), "uint8"), np.eye(4), names, Origin("x"))
    assert LabelMapFormat.decode(LabelMapFormat.encode(label_map)).names == names


def test_simpleitk_reads_labels_places_and_segment_names(tmp_path: Path) -> None:
    import SimpleITK as sitk

    affine = np.array([[0, 0, 2.5, 10], [-0.7, 0, 0, 20], [0, 0.7, 0, -30], [0, 0, 0, 1]])
    values = np.arange(24, dtype="uint8").reshape(2, 3, 4) % 3
    label_map = LabelMap(values, affine, ("left lung", "bone"), Origin("x"))
    path = tmp_path / "labels.seg.nrrd"
    path.write_bytes(LabelMapFormat.encode(label_map)["labels.seg.nrrd"])
    image = sitk.ReadImage(str(path))
    for index in np.ndindex(values.shape):
        assert image.GetPixel(index) == values[index]
    assert image.TransformIndexToPhysicalPoint((1, 2, 3)) == pytest.approx(
        (10 + 3 * 2.5, 20 - 0.7, -30 + 1.4)
    )
    assert image.GetMetaData("Segment0_Name") == "left lung"
    assert image.GetMetaData("Segment1_LabelValue") == "2"
    colours = {image.GetMetaData(f"Segment{n}_Color") for n in (0, 1)}
    assert len(colours) == 2
    assert all(0 <= float(c) <= 1 for colour in colours for c in colour.split())
