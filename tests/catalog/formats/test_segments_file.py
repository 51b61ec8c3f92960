"""Segmentations as 3D Slicer saves them: each segment in its layer, with its name and place."""

from io import BytesIO

import numpy as np
import pytest

from catalog.formats.label_files import LabelFilesFormat
from nodes.errors import BadInput

MASK = np.zeros((6, 5, 4), np.uint8)
MASK[1:4, 2:5, 1:3] = 1
STEP, START = np.array([0.5, 0.75, 2.0]), np.array([-10.0, 20.0, 30.0])


def segmentation(numbers: np.ndarray, *segments: tuple[str, int, int], **more) -> bytes:
    """Bytes with segments (name, label value, layer); layers are the first axis of four."""
    import nrrd

    layered = numbers.ndim == 4
    header = {
        "space": "left-posterior-superior",
        "kinds": ["list"] * layered + ["domain"] * 3,
        "space directions": np.vstack([np.full((int(layered), 3), np.nan), np.diag(STEP)]),
        "space origin": START,
        "encoding": "gzip",
        "Segmentation_MasterRepresentation": "Binary labelmap",
        **more,
    }
    for n, (name, value, layer) in enumerate(segments):
        header |= {
            f"Segment{n}_ID": f"Segment_{n + 1}",
            f"Segment{n}_Name": name,
            f"Segment{n}_LabelValue": str(value),
            f"Segment{n}_Layer": str(layer),
            f"Segment{n}_Extent": "0 5 0 4 0 3",
        }
    buffer = BytesIO()
    nrrd.write(buffer, numbers, header)
    return buffer.getvalue()


def decode(content: bytes, name: str = "case.seg.nrrd"):
    return LabelFilesFormat.decode({name: content}).maps


def test_segments_give_their_names_and_numbers():
    numbers = MASK * 7
    numbers[0, 0, 0] = 3
    (labels,) = decode(segmentation(numbers, ("right lung", 7, 0), ("50 % mark", 3, 0)))
    assert labels.content.names == ("50 % mark", "right lung")
    assert labels.content.mask("right lung").sum() == 18
    np.testing.assert_allclose(labels.content.patient_from_index[:3, 3], START)


def test_overlapping_segments_come_from_their_layers():
    other = np.roll(MASK, 1, axis=0)
    numbers = np.stack([MASK, other * 1 + (MASK - MASK * other) * 2])
    maps = decode(segmentation(numbers, ("a", 1, 0), ("b", 1, 1), ("c", 2, 1)))
    assert [each.content.names for each in maps] == [("a",), ("b", "c")]
    for labels, name, mask in ((maps[0], "a", MASK), (maps[1], "b", other)):
        index = np.argwhere(labels.content.mask(name)) + labels.corner
        np.testing.assert_array_equal(index, np.argwhere(mask))
        np.testing.assert_allclose(labels.patient_from_grid[:3, 3], START)
        np.testing.assert_allclose(labels.patient_from_grid[:3, :3], np.diag(STEP))


def test_places_are_those_that_simpleitk_reads(tmp_path):
    import SimpleITK as sitk

    for space in ("left-posterior-superior", "right-anterior-superior", "LAS"):
        content = segmentation(MASK, ("a", 1, 0), space=space)
        (tmp_path / "a.nrrd").write_bytes(content)
        image = sitk.ReadImage(str(tmp_path / "a.nrrd"))
        matrix = decode(content)[0].patient_from_grid
        for index in ((0, 0, 0), (5, 4, 3)):
            place = image.TransformIndexToPhysicalPoint(index)
            np.testing.assert_allclose(matrix @ [*index, 1], [*place, 1], atol=1e-9)


def test_numbers_without_a_segment_are_kept_under_the_files_name():
    numbers = MASK * 7
    numbers[0, 0, 0] = 3
    assert decode(segmentation(numbers, ("lung", 7, 0)))[0].content.names == ("case_3", "lung")


def test_an_empty_segment_is_refused_by_its_name():
    with pytest.raises(BadInput, match="case: label tumour has 0 voxels"):
        decode(segmentation(MASK, ("lung", 1, 0), ("tumour", 2, 0)))


def test_segments_of_one_name_are_refused():
    numbers = np.stack([MASK, MASK])
    with pytest.raises(BadInput, match="2 labels are called a"):
        decode(segmentation(numbers, ("a", 1, 0), ("a", 1, 1)))


@pytest.mark.parametrize("share", [0.3, 0.97])
def test_a_segmentation_that_is_cut_off_is_refused(share):
    noise = np.random.default_rng(0).integers(0, 2, (20, 20, 20)).astype(np.uint8)
    content = segmentation(noise, ("lung", 1, 0))
    with pytest.raises(BadInput, match="case: the segmentation is cut off"):
        decode(content[: int(share * len(content))])


def test_a_segmentation_without_the_patients_axes_is_refused():
    with pytest.raises(BadInput, match="case: space scanner-xyz"):
        decode(segmentation(MASK, ("lung", 1, 0), space="scanner-xyz"))
