"""Label maps as people have them: names, numbers and places are right, and all else is refused."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from catalog.formats.label_files import LabelFilesFormat
from catalog.formats.labelmap import LabelMapFormat
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.label_files import FileLabels, LabelFiles
from nodes.geometry.origin import Origin
from tests.catalog.formats.hostile import NAMES, ORIGINS, affines, assert_same

STEP, START = (0.5, 0.75, 2.0), (-10.0, 20.0, 30.0)
MASK = np.zeros((6, 5, 4), np.uint8)
MASK[1:4, 2:5, 1:3] = 1


def volume_file(voxels: np.ndarray, name: str, folder: Path) -> bytes:
    """Bytes as SimpleITK writes them, voxels [i, j, k], along LPS axes."""
    import SimpleITK as sitk

    image = sitk.GetImageFromArray(np.ascontiguousarray(voxels.transpose(2, 1, 0)))
    image.SetSpacing(STEP)
    image.SetOrigin(START)
    sitk.WriteImage(image, str(folder / name), useCompression=name.endswith("gz"))
    return (folder / name).read_bytes()


def decode(voxels: np.ndarray, folder: Path, name: str = "liver.nii.gz") -> LabelFiles:
    return LabelFilesFormat.decode({name: volume_file(voxels, name, folder)})


def places(labels: FileLabels, name: str) -> np.ndarray:
    """Voxel centres of a label in patient LPS mm, sorted."""
    index = np.argwhere(labels.content.mask(name))
    matrix = labels.content.patient_from_index
    found = index @ matrix[:3, :3].T + matrix[:3, 3]
    return found[np.lexsort(found.T.round(6))]


def expected_places(mask: np.ndarray) -> np.ndarray:
    found = np.argwhere(mask) * STEP + START
    return found[np.lexsort(found.T.round(6))]


@pytest.mark.parametrize("suffix", [".nii", ".nii.gz", ".nrrd", ".mha"])
@pytest.mark.parametrize("dtype", ["uint8", "int16", "int32", "float32"])
def test_a_mask_is_called_by_its_file_and_lies_in_its_place(suffix, dtype, tmp_path):
    read = decode(MASK.astype(dtype), tmp_path, "left_kidney" + suffix)
    assert [each.content.names for each in read.maps] == [("left_kidney",)]
    labels = read.maps[0]
    np.testing.assert_allclose(places(labels, "left_kidney"), expected_places(MASK), atol=1e-5)
    assert labels.corner == (1, 2, 1) and labels.content.voxels.shape == (3, 3, 2)
    assert labels.grid_shape == MASK.shape
    np.testing.assert_allclose(labels.patient_from_grid[:3, 3], START, atol=1e-5)


def test_any_number_above_zero_makes_a_mask(tmp_path):
    assert decode(MASK * 255, tmp_path).maps[0].content.names == ("liver",)


def test_several_numbers_are_told_apart_by_file_and_number(tmp_path):
    numbers = MASK.astype(np.int32)
    numbers[0, 0, 0], numbers[5, 4, 3] = 70000, 300
    labels = decode(numbers, tmp_path, "organs.nrrd").maps[0]
    assert labels.content.names == ("organs_1", "organs_300", "organs_70000")
    np.testing.assert_allclose(places(labels, "organs_300"), [np.array([5, 4, 3]) * STEP + START])
    np.testing.assert_allclose(places(labels, "organs_70000"), [START])


def test_numbers_may_be_as_large_as_floats(tmp_path):
    labels = decode(MASK * np.float32(2**40), tmp_path).maps[0]
    np.testing.assert_array_equal(labels.content.voxels, MASK[1:4, 2:5, 1:3])


def test_nesting_does_not_matter_and_other_files_are_counted(tmp_path):
    content = volume_file(MASK, "a.nii", tmp_path)
    read = LabelFilesFormat.decode(
        {
            "x/a.nii": content,
            "y/z/b.nii": content,
            "LICENSE": b"text",
            "x/start1.txt": b"1 2 3",
            "x/._a.nii": b"of macOS",
            "c.mgz": b"FreeSurfer",
        }
    )
    assert [each.content.names for each in read.maps] == [("a",), ("b",)]
    assert read.skipped == 4


def test_a_header_and_its_pixels_count_as_one_file(tmp_path):
    volume_file(MASK, "liver.mhd", tmp_path)
    files = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert len(files) == 2
    read = LabelFilesFormat.decode(files)
    assert read.maps[0].content.names == ("liver",) and read.skipped == 0


def test_no_file_means_that_nothing_is_handed_in():
    assert LabelFilesFormat.decode({}) == LabelFiles(())


def test_our_own_label_map_keeps_names_and_origin():
    origin = Origin("phantom", True, ("simulated",))
    own = LabelMap(MASK, np.eye(4), ("left lung, 100 %",), origin)
    read = LabelFilesFormat.decode(LabelMapFormat.encode(own))
    assert read.maps[0].content.names == own.names and read.maps[0].content.origin == origin
    np.testing.assert_array_equal(read.maps[0].content.voxels, MASK[1:4, 2:5, 1:3])


LABELS = st.integers(1, 4).flatmap(
    lambda n: hnp.arrays(np.uint8, (2, 3, 2), elements=st.integers(0, n)).filter(
        lambda voxels: len(np.unique(voxels[voxels > 0])) == voxels.max(initial=0) > 0
    )
)


@st.composite
def file_labels(draw: st.DrawFn) -> FileLabels:
    voxels = draw(LABELS)
    count = int(voxels.max())
    names = tuple(draw(st.lists(NAMES, min_size=count, max_size=count)))
    corner = draw(st.tuples(*[st.integers(0, 3)] * 3))
    content = LabelMap(voxels, draw(affines()), names, draw(ORIGINS))
    return FileLabels(content, corner, (9, 8, 7))


@settings(max_examples=40, deadline=None)
@given(st.lists(file_labels(), max_size=3), st.integers(0, 5))
def test_everything_comes_back_from_the_store(maps, skipped):
    kept = LabelFiles(tuple(maps), skipped)
    files = LabelFilesFormat.encode(kept)
    back = LabelFilesFormat.decode(files)
    assert files and back.skipped == skipped and len(back.maps) == len(maps)
    for mine, other in zip(maps, back.maps, strict=True):
        assert (mine.corner, mine.grid_shape) == (other.corner, other.grid_shape)
        assert (mine.content.names, mine.content.origin) == (
            other.content.names,
            other.content.origin,
        )
        assert_same(mine.content.voxels, other.content.voxels)
        assert_same(mine.content.patient_from_index, other.content.patient_from_index)


def refused(voxels: np.ndarray, folder: Path) -> str:
    with pytest.raises(BadInput) as caught:
        decode(voxels, folder)
    return str(caught.value)


def test_a_probability_map_is_refused_with_its_value_and_a_cure(tmp_path):
    told = refused(MASK * np.float32(0.25), tmp_path)
    assert told.startswith("liver: the value 0.25\n") and "cut a probability map off" in told


def test_an_image_is_refused_for_its_negative_values(tmp_path):
    told = refused(MASK.astype(np.int16) - 1024, tmp_path)
    assert told.startswith("liver: the value -1024\n") and "not the image" in told


def test_nan_is_refused(tmp_path):
    voxels = MASK.astype(np.float32)
    voxels[0, 0, 0] = np.nan
    with pytest.raises(BadInput, match="liver: the value nan"):  # ITK reads NIfTI's NaN as 0
        decode(voxels, tmp_path, "liver.nrrd")


def test_an_image_is_refused_for_its_many_values(tmp_path):
    told = refused(np.arange(7 * 7 * 7, dtype=np.int16).reshape(7, 7, 7), tmp_path)
    assert "liver: 342 different numbers, up to 342" in told and "at most 255" in told


def test_an_empty_mask_is_refused_by_its_name(tmp_path):
    assert refused(MASK * 0, tmp_path).startswith("liver: 0 voxels\n")


def test_an_image_in_time_or_colour_is_refused(tmp_path):
    import SimpleITK as sitk

    image = sitk.GetImageFromArray(np.stack([MASK, MASK]), isVector=False)
    sitk.WriteImage(image, str(tmp_path / "series.nii"))
    with pytest.raises(BadInput, match=r"series: .*6 x 2(?s:.*)3 dimensions"):
        LabelFilesFormat.decode({"series.nii": (tmp_path / "series.nii").read_bytes()})


@pytest.mark.parametrize("name", ["liver.nii", "liver.nii.gz", "liver.nrrd", "liver.mha"])
def test_a_file_that_is_cut_off_is_refused_by_its_name(name, tmp_path):
    noise = np.random.default_rng(0).integers(0, 2, (20, 20, 20)).astype(np.uint8)
    content = volume_file(noise, name, tmp_path)
    with pytest.raises(BadInput, match="liver: the volume file is cut off"):
        LabelFilesFormat.decode({name: content[: len(content) // 2]})


def test_two_labels_of_one_name_are_refused(tmp_path):
    content = volume_file(MASK, "kidney.nii", tmp_path)
    with pytest.raises(BadInput, match="2 labels are called kidney"):
        LabelFilesFormat.decode({"left/kidney.nii": content, "right/kidney.nii": content})


def test_a_folder_without_label_maps_is_refused_with_what_would_be_one():
    with pytest.raises(BadInput, match=r"2 files, none a label map\n.*\.nii\.gz"):
        LabelFilesFormat.decode({"secret_name.txt": b"", "b.mgz": b""})
    with pytest.raises(BadInput) as caught:
        LabelFilesFormat.decode({"secret_name.txt": b""})
    assert "secret" not in str(caught.value)


def test_organs_of_a_real_abdomen_are_read(test_data):
    content = (test_data / "abdomen_ct/example_seg.nii.gz").read_bytes()
    labels = LabelFilesFormat.decode({"organs.nii.gz": content}).maps[0]
    assert len(labels.content.names) > 10
    assert all(name.startswith("organs_") for name in labels.content.names)
