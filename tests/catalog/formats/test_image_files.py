"""Image files: what is written is read back, by others too, and no identifier comes along."""

import gzip
import pickle
import re
import struct
from io import BytesIO
from pathlib import Path

import numpy as np
import pydicom
import pytest
import SimpleITK as sitk
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from catalog.formats.image_files import ImageFilesFormat
from nodes.errors import BadInput
from nodes.imaging.artefacts import ImageFiles, Slice


def planes(count=4, shape=(5, 7), seed=0, series=1, modality="CT", unit="HU"):
    """Planes of an oblique stack with random values."""
    chance = np.random.default_rng(seed)
    axes = Rotation.random(rng=chance).as_matrix()
    matrices = [np.eye(4) for _ in range(count)]
    start = chance.uniform(-200, 200, 3)
    for number, matrix in enumerate(matrices):
        matrix[:3, :3] = axes * [0.7, 0.9, 1.0]
        matrix[:3, 3] = start + 2.5 * number * axes[:, 2]
    return tuple(
        Slice(chance.integers(-1024, 3000, shape).astype(np.int16), matrix, series, modality, unit)
        for matrix in matrices
    )


def assert_same(left: ImageFiles, right: ImageFiles) -> None:
    assert len(left.slices) == len(right.slices)
    for one, other in zip(left.slices, right.slices, strict=True):
        assert one.pixels.dtype == other.pixels.dtype
        np.testing.assert_array_equal(one.pixels, other.pixels)
        np.testing.assert_allclose(one.patient_from_pixel, other.patient_from_pixel, atol=1e-8)
        assert (one.series, one.modality, one.unit) == (other.series, other.modality, other.unit)


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 4), st.tuples(st.integers(1, 6), st.integers(1, 6)), st.integers(0, 999))
def test_planes_come_back_in_order_with_values_and_places(count, shape, seed):
    value = ImageFiles(planes(count, shape, seed), simulated=bool(seed % 2))
    again = ImageFilesFormat.decode(ImageFilesFormat.encode(value))
    assert_same(again, value)
    assert again.simulated == value.simulated


def test_series_modality_and_unit_come_back():
    value = ImageFiles(planes(2) + planes(3, seed=1, series=2, modality="MR", unit="intensity"))
    assert_same(ImageFilesFormat.decode(ImageFilesFormat.encode(value)), value)


def test_equal_values_give_equal_bytes_and_other_values_other_uids():
    first, same = (ImageFilesFormat.encode(ImageFiles(planes())) for _ in range(2))
    other = ImageFilesFormat.encode(ImageFiles(planes(seed=1)))
    assert first == same
    uids = [
        pydicom.dcmread(BytesIO(content)).SOPInstanceUID
        for content in [*first.values(), *other.values()]
    ]
    assert len(set(uids)) == len(uids)


def test_itk_reads_the_series_at_the_same_places(tmp_path):
    value = ImageFiles(planes())
    for name, content in ImageFilesFormat.encode(value).items():
        (tmp_path / name).write_bytes(content)
    names = sitk.ImageSeriesReader.GetGDCMSeriesFileNames(str(tmp_path))
    image = sitk.ReadImage(names)
    for k, plane in enumerate(value.slices):
        place = image.TransformIndexToPhysicalPoint((6, 4, k))
        np.testing.assert_allclose(place, (plane.patient_from_pixel @ [6, 4, 0, 1])[:3], atol=1e-3)
        assert image[6, 4, k] == plane.pixels[4, 6]


def test_no_identifier_leaves_the_files():
    files = ImageFilesFormat.encode(ImageFiles(planes(), simulated=True))
    assert all(b"PHANTOM^THORAX" in file and b"19010203" in file for file in files.values())
    dataset = pydicom.dcmread(BytesIO(files["slice_0001.dcm"]))
    decoded = ImageFilesFormat.decode(files)
    seen = pickle.dumps(decoded) + repr(decoded).encode()
    for element in dataset:
        identifies = element.VR in ("PN", "UI", "DA", "TM", "SH", "LO") and str(element.value)
        if identifies and element.keyword not in ("RescaleType", "SeriesDescription"):
            assert str(element.value).encode() not in seen, element.keyword


def test_real_people_are_not_named_after_the_phantom():
    files = ImageFilesFormat.encode(ImageFiles(planes()))
    assert not any(b"PHANTOM" in content for content in files.values())


def test_warnings_about_broken_identifiers_stay_inside(recwarn):
    files = ImageFilesFormat.encode(ImageFiles(planes()))
    broken = {name: re.sub(rb"2\.25\.\d\d", b"SECRETS", content) for name, content in files.items()}
    ImageFilesFormat.decode(broken)
    assert not [warning for warning in recwarn if "SECRETS" in str(warning.message)]


def test_packed_pixels_are_unpacked_exactly():
    value = ImageFiles(planes(shape=(40, 30)))
    packed = {}
    for name, content in ImageFilesFormat.encode(value).items():
        dataset = pydicom.dcmread(BytesIO(content))
        dataset.compress(pydicom.uid.RLELossless, generate_instance_uid=False)
        file = BytesIO()
        dataset.save_as(file)
        packed[name] = file.getvalue()
    assert_same(ImageFilesFormat.decode(packed), value)


def test_old_files_without_preamble_are_read():
    value = ImageFiles(planes())
    bare = {}
    for name, content in ImageFilesFormat.encode(value).items():
        dataset = pydicom.dcmread(BytesIO(content))
        del dataset.file_meta
        dataset.preamble = None
        file = BytesIO()
        pydicom.dcmwrite(file, dataset, implicit_vr=True, little_endian=True)
        bare[name] = file.getvalue()
        assert bare[name][:2] == b"\x08\x00"
    assert_same(ImageFilesFormat.decode(bare), value)


def rescaled(slope: str, intercept: str) -> Slice:
    content = ImageFilesFormat.encode(ImageFiles(planes(1)))["slice_0001.dcm"]
    dataset = pydicom.dcmread(BytesIO(content))
    dataset.RescaleSlope, dataset.RescaleIntercept = slope, intercept
    file = BytesIO()
    dataset.save_as(file)
    return ImageFilesFormat.decode({"a": file.getvalue()}).slices[0]


@pytest.mark.parametrize(
    ("slope", "intercept", "kind"),
    [("2", "-24", np.int16), ("0.5", "0", np.float32), ("1", "32000", np.float32)],
)
def test_rescaling_is_applied_and_whole_numbers_that_fit_stay_whole(slope, intercept, kind):
    expected = planes(1)[0].pixels * float(slope) + float(intercept)
    plane = rescaled(slope, intercept)
    assert plane.pixels.dtype == kind
    np.testing.assert_array_equal(plane.pixels, expected)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.999])
def test_a_cut_off_file_is_refused_and_not_named(share):
    files = ImageFilesFormat.encode(ImageFiles(planes(shape=(30, 30)), simulated=True))
    content = files["slice_0002.dcm"]
    files["slice_0002.dcm"] = content[: int(len(content) * share)]
    with pytest.raises(BadInput, match="file 2 of 4") as caught:
        ImageFilesFormat.decode(files)
    assert "slice" not in str(caught.value) and "PHANTOM" not in str(caught.value)


@pytest.mark.parametrize("name", ["slice_0001.dcm", "slice_0004.dcm", "slice_0002.IMA", "IM0009"])
@pytest.mark.parametrize("content", [b"", b"cut", b"\0" * 200])
def test_what_is_named_as_a_slice_but_is_none_is_refused(name, content):
    """Left out at either end of a series, it would cut the anatomy short without a word."""
    files = ImageFilesFormat.encode(ImageFiles(planes()))
    if name == "IM0009" and content:
        assert ImageFilesFormat.decode({**files, name: content}).skipped == 1
        return
    with pytest.raises(BadInput, match="cut off or damaged"):
        ImageFilesFormat.decode({**files, name: content})


@pytest.mark.parametrize("files", [{}, {"notes.txt": b"nothing here"}, {"empty.txt": b""}])
def test_nothing_to_read_is_refused_with_a_cure(files):
    with pytest.raises(BadInput, match="cure: name the folder"):
        ImageFilesFormat.decode(files)


def test_other_files_in_any_folder_are_counted_as_skipped():
    files = ImageFilesFormat.encode(ImageFiles(planes()))
    nested = {f"a/b c/{name}": content for name, content in files.items()}
    again = ImageFilesFormat.decode({**nested, "a/notes.txt": b"text", "DICOMDIR": b"\0" * 200})
    assert again.skipped == 2
    assert len(again.slices) == 4


def colour_image() -> bytes:
    content = ImageFilesFormat.encode(ImageFiles(planes(1)))["slice_0001.dcm"]
    dataset = pydicom.dcmread(BytesIO(content))
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 3, "RGB"
    dataset.PlanarConfiguration, dataset.BitsAllocated, dataset.BitsStored = 0, 8, 8
    dataset.HighBit, dataset.PixelRepresentation = 7, 0
    dataset.PixelData = bytes(dataset.Rows * dataset.Columns * 3 + 1)
    file = BytesIO()
    dataset.save_as(file)
    return file.getvalue()


def test_colour_captures_are_skipped():
    files = ImageFilesFormat.encode(ImageFiles(planes()))
    assert ImageFilesFormat.decode({**files, "capture.dcm": colour_image()}).skipped == 1


def itk_image(seed: int = 0) -> sitk.Image:
    chance = np.random.default_rng(seed)
    image = sitk.GetImageFromArray(chance.integers(-1000, 1000, (4, 5, 6)).astype(np.int16))
    image.SetSpacing((0.7, 0.9, 2.5))
    image.SetDirection(Rotation.random(rng=chance).as_matrix().ravel().tolist())
    image.SetOrigin((10.0, -20.0, 30.0))
    return image


def written(image: sitk.Image, folder: Path, name: str) -> dict[str, bytes]:
    sitk.WriteImage(image, str(folder / name))
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("name", ["v.nii", "v.nii.gz", "v.nrrd", "v.nhdr", "v.mha", "v.mhd"])
def test_a_volume_file_keeps_values_and_places(tmp_path, name):
    image = itk_image()
    files = {f"deep/{key}": content for key, content in written(image, tmp_path, name).items()}
    decoded = ImageFilesFormat.decode({**files, "readme.txt": b""})
    volume = decoded.volume
    assert decoded.skipped == 1 and decoded.slices == ()
    assert volume.voxels.dtype == np.int16
    for index in ((0, 0, 0), (5, 4, 3), (2, 3, 1)):
        assert volume.voxels[index] == image[index]
        place = (volume.patient_from_index @ [*index, 1])[:3]
        np.testing.assert_allclose(place, image.TransformIndexToPhysicalPoint(index), atol=1e-4)


def nifti_bytes(voxels: np.ndarray, affine: np.ndarray) -> bytes:
    """A NIfTI-1 file by its standard: header of 348 bytes, int16, sform."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *voxels.shape, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, *np.linalg.norm(affine[:3, :3], axis=0), 0, 0, 0, 0)
    struct.pack_into("<2f", header, 108, 352, 1)
    struct.pack_into("<2h", header, 252, 0, 1)
    struct.pack_into("<12f", header, 280, *affine[:3].ravel())
    header[344:348] = b"n+1\0"
    return bytes(header) + voxels.astype("<i2").tobytes(order="F")


def read_nifti(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Values and affine (RAS) of a NIfTI-1 file of small whole numbers."""
    content = gzip.decompress(path.read_bytes())
    shape = struct.unpack_from("<3h", content, 42)
    assert struct.unpack_from("<h", content, 70)[0] in (4, 512)  # int16, uint16
    start = int(struct.unpack_from("<f", content, 108)[0])
    affine = np.vstack([np.reshape(struct.unpack_from("<12f", content, 280), (3, 4)), [0, 0, 0, 1]])
    return np.frombuffer(content, "<i2", offset=start).reshape(shape, order="F"), affine


def test_nifti_coordinates_are_turned_from_ras_to_lps():
    affine = np.array([[2.0, 0, 0, 5], [0, 3, 0, 6], [0, 0, 4, 7], [0, 0, 0, 1]])
    voxels = np.arange(24).reshape(2, 3, 4)
    volume = ImageFilesFormat.decode({"a.nii": nifti_bytes(voxels, affine)}).volume
    np.testing.assert_array_equal(volume.voxels, voxels)
    np.testing.assert_allclose(
        volume.patient_from_index, np.diag([-1.0, -1, 1, 1]) @ affine, atol=1e-5
    )


def test_a_volume_comes_back_after_encoding(tmp_path):
    value = ImageFilesFormat.decode(written(itk_image(), tmp_path, "v.nrrd"))
    again = ImageFilesFormat.decode(ImageFilesFormat.encode(value))
    np.testing.assert_array_equal(again.volume.voxels, value.volume.voxels)
    np.testing.assert_allclose(
        again.volume.patient_from_index, value.volume.patient_from_index, atol=1e-9
    )


@pytest.mark.parametrize("name", ["v.nii", "v.nii.gz", "v.nrrd", "v.mha"])
def test_a_cut_off_volume_file_is_refused(tmp_path, name):
    content = written(itk_image(), tmp_path, name)[name]
    with pytest.raises(BadInput, match="cut off"):
        ImageFilesFormat.decode({name: content[:-60]})


def test_a_header_cannot_reach_out_of_the_input(tmp_path):
    secret = tmp_path / "elsewhere"
    secret.mkdir()
    files = written(itk_image(), secret, "v.mhd")
    header = files["v.mhd"].replace(b"v.raw", str(secret / "v.raw").encode())
    with pytest.raises(BadInput, match="beside"):
        ImageFilesFormat.decode({"v.mhd": header})
    with pytest.raises(BadInput, match="beside"):
        ImageFilesFormat.decode({"v.mhd": files["v.mhd"]})


def test_planes_beside_a_volume_and_several_volumes_are_refused(tmp_path):
    volume = written(itk_image(), tmp_path, "v.mha")["v.mha"]
    with pytest.raises(BadInput, match="1 volume files and 4 DICOM planes"):
        ImageFilesFormat.decode({**ImageFilesFormat.encode(ImageFiles(planes())), "v.mha": volume})
    with pytest.raises(BadInput, match="2 volume files"):
        ImageFilesFormat.decode({"a.mha": volume, "b.mha": volume})


def folder(path: Path) -> dict[str, bytes]:
    return {str(p.relative_to(path)): p.read_bytes() for p in path.rglob("*") if p.is_file()}


def test_a_real_compressed_series_is_read_as_itk_reads_it(test_data):
    path = test_data / "chest_ct" / "P002"
    files = {name: content for name, content in folder(path).items() if name < "slice_0006"}
    decoded = ImageFilesFormat.decode(files)
    for name, plane in zip(sorted(files), decoded.slices, strict=True):
        image = sitk.ReadImage(str(path / name))
        np.testing.assert_array_equal(plane.pixels, sitk.GetArrayFromImage(image)[0])
        assert plane.unit == "HU"
        np.testing.assert_allclose(plane.patient_from_pixel[:3, 3], image.GetOrigin(), atol=1e-6)


@pytest.mark.parametrize("packing", ["compressed", "compressed_j2k", "compressed_rle",
                                     "compressed_jpegls"])  # fmt: skip
def test_every_lossless_packing_gives_the_published_values(test_data, packing):
    root = test_data / "dicom_traps" / "generic" / packing
    voxels, affine = read_nifti(root / "001_ground_truth.nii.gz")
    for plane in ImageFilesFormat.decode(folder(root / "001")).slices:
        rows, columns = np.indices(plane.pixels.shape).reshape(2, -1)
        pixels = np.stack([columns, rows, 0 * rows, 1 + 0 * rows])
        places = np.diag([-1, -1, 1, 1]) @ plane.patient_from_pixel @ pixels
        i, j, k, _ = np.rint(np.linalg.solve(affine, places)).astype(int)
        np.testing.assert_array_equal(plane.pixels.ravel(), voxels[i, j, k])


def test_no_warning_quotes_a_value(caplog, recwarn):
    files = {}
    for name, data in ImageFilesFormat.encode(ImageFiles(planes())).items():
        dataset = pydicom.dcmread(BytesIO(data))
        dataset.add_new("FrameOfReferenceUID", "UI", "Qwxdoe-uid")
        buffer = BytesIO()
        dataset.save_as(buffer)
        files[name] = buffer.getvalue()
    caplog.clear()
    recwarn.clear()
    ImageFilesFormat.decode(files)
    assert caplog.records == []
    assert len(recwarn) == 0


@pytest.mark.parametrize("kind", [np.float32, np.float64, ">f4"])
@pytest.mark.parametrize("strange", [np.nan, np.inf])
def test_a_nifti_file_with_voxels_that_are_no_number_is_refused(tmp_path, kind, strange):
    """ITK would read them as 0, which is soft tissue."""
    values = np.full((4, 5, 6), -700.0, np.float32)
    image = sitk.GetImageFromArray(values.astype(np.dtype(kind).newbyteorder("=")))
    path = tmp_path / "a.nii"
    sitk.WriteImage(image, str(path))
    content = path.read_bytes()
    size = np.dtype(kind).itemsize
    if kind == ">f4":
        content = swapped_nifti(content)
    assert ImageFilesFormat.decode({"a.nii": content}).volume is not None
    spoilt = np.array([strange], kind).tobytes()
    spoilt = content[:352] + 2 * spoilt + content[352 + 2 * size :]
    assert len(spoilt) == len(content) == 352 + values.size * size
    with pytest.raises(BadInput, match="2 voxels are not a number"):
        ImageFilesFormat.decode({"a.nii": spoilt})


def swapped_nifti(content: bytes) -> bytes:
    """Return a NIfTI-1 float32 file with the other byte order; fields by the standard."""
    head = np.frombuffer(content[:352], np.uint8).copy()
    for start, count, size in ((0, 1, 4), (32, 1, 4), (40, 8, 2), (56, 3, 4), (68, 4, 2),
                               (76, 8, 4), (108, 3, 4), (120, 1, 2), (124, 6, 4), (252, 2, 2),
                               (256, 18, 4)):  # fmt: skip
        part = head[start : start + count * size].reshape(count, size)
        head[start : start + count * size] = part[:, ::-1].ravel()
    values = np.frombuffer(content[352:], np.uint8).reshape(-1, 4)[:, ::-1]
    return head.tobytes() + values.tobytes()
