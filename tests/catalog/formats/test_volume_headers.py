"""Where volume files lie in the patient: read right, told where in doubt, refused where unknown."""

import gzip
import struct
from contextlib import suppress

import numpy as np
import pytest
import SimpleITK as sitk
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from catalog.formats.image_files import ImageFilesFormat
from nodes.errors import BadInput

LPS_FROM_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
SHAPE = (3, 4, 5)
VALUES = np.arange(60).reshape(SHAPE)
SPACING = np.array([2.0, 3.0, 4.0])


def affine(turn=(0, 0, 0), origin=(5, 6, 7), spacing=SPACING):
    """A grid in RAS mm."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", turn, degrees=True).as_matrix() * spacing
    matrix[:3, 3] = origin
    return matrix


def nifti(sform=None, qform=None, codes=(1, 1), frames=None, end="<", units=2, scale=(0, 0),
          spacing=SPACING):  # fmt: skip
    """A NIfTI-1 file of int16 by its standard; sform and qform are affines in RAS mm."""
    header = bytearray(352)
    size = [3, *SHAPE, 1] if frames is None else [4, *SHAPE, frames]
    struct.pack_into(f"{end}i", header, 0, 348)
    struct.pack_into(f"{end}8h", header, 40, *size, 1, 1, 1)
    struct.pack_into(f"{end}2h", header, 70, 4, 16)
    struct.pack_into(f"{end}8f", header, 76, 1, *spacing, 1, 0, 0, 0)
    struct.pack_into(f"{end}3f", header, 108, 352, *scale)
    header[123] = units
    if qform is not None:
        hand = np.sign(np.linalg.det(qform))
        turn = Rotation.from_matrix(qform[:3, :3] / SPACING * [1, 1, hand])
        quaternion = turn.as_quat(canonical=True)
        struct.pack_into(f"{end}f", header, 76, hand)
        struct.pack_into(f"{end}h", header, 252, codes[1])
        struct.pack_into(f"{end}6f", header, 256, *quaternion[:3], *qform[:3, 3])
    if sform is not None:
        struct.pack_into(f"{end}h", header, 254, codes[0])
        struct.pack_into(f"{end}12f", header, 280, *sform[:3].ravel())
    header[344:348] = b"n+1\0"
    values = np.stack([VALUES] * (frames or 1), axis=-1)
    return bytes(header) + values.astype(f"{end}i2").tobytes(order="F")


def read(content, name="v.nii"):
    return ImageFilesFormat.decode({name: content}).volume


@settings(max_examples=25, deadline=None)
@given(
    st.tuples(*[st.floats(-180, 180)] * 3),
    st.sampled_from(["sform", "qform", "both"]),
    st.sampled_from("<>"),
    st.sampled_from([1, -1]),
)
def test_any_nifti_lies_where_its_header_says(turn, forms, end, hand):
    matrix = affine(turn) @ np.diag([1, 1, hand, 1])
    places = {form: matrix for form in ("sform", "qform") if forms in (form, "both")}
    volume = read(nifti(**places, end=end))
    np.testing.assert_array_equal(volume.voxels, VALUES)
    np.testing.assert_allclose(volume.patient_from_index, LPS_FROM_RAS @ matrix, atol=1e-4)
    assert volume.origin.notices == ()


@pytest.mark.parametrize(
    ("codes", "used"), [((1, 1), "sform"), ((2, 1), "qform"), ((1, 2), "sform")]
)
def test_two_places_are_told_with_their_distance_and_which_was_used(codes, used):
    forms = {"sform": affine(), "qform": affine(origin=(5, 6, 17))}
    volume = read(nifti(**forms, codes=codes))
    np.testing.assert_allclose(volume.patient_from_index, LPS_FROM_RAS @ forms[used], atol=1e-5)
    assert volume.origin.notices == (
        f"the header places the volume twice, up to 10.0 mm apart: its {used} was used",
    )


@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_a_mirrored_qform_beside_an_sform_is_told(pack):
    mirrored = affine() @ np.diag([1, 1, -1, 1])
    name = "v.nii" if pack is bytes else "v.nii.gz"
    (notice,) = read(pack(nifti(affine(), mirrored)), name).origin.notices
    assert notice.startswith("the header places the volume twice, up to 32.0 mm apart")
    assert read(pack(nifti(mirrored, mirrored)), name).origin.notices == ()


def test_a_mirrored_file_that_itk_wrote_is_read_without_doubt(tmp_path):
    image = sitk.GetImageFromArray(np.zeros((3, 4, 5), np.int16))
    image.SetDirection((1, 0, 0, 0, 1, 0, 0, 0, -1))
    path = tmp_path / "v.nii"
    sitk.WriteImage(image, str(path))
    assert read(path.read_bytes()).origin.notices == ()


def test_places_that_differ_by_rounding_are_one():
    volume = read(nifti(affine(), affine((0, 0, 0.05), (5.01, 6, 7))))
    assert volume.origin.notices == ()


def test_a_nifti_without_a_place_is_refused():
    with pytest.raises(BadInput, match="neither sform nor qform"):
        read(nifti())


def test_an_sform_askew_is_refused_and_a_qform_beside_it_used_with_notice():
    askew = affine()
    askew[0, 2] = 1
    with pytest.raises(BadInput, match="not at right angles"):
        read(nifti(askew))
    (notice,) = read(nifti(askew, affine())).origin.notices
    assert "its qform was used" in notice


def test_an_sform_that_contradicts_the_voxel_size_is_refused():
    """ITK takes the directions of the one and the spacing of the other."""
    with pytest.raises(BadInput, match="sform and voxel size put corners of the volume"):
        read(nifti(affine(), spacing=(1, 1, 1)))


@pytest.mark.parametrize(("units", "factor"), [(0, 1), (1, 1000), (2, 1), (3, 0.001), (10, 1)])
def test_units_of_a_nifti_become_mm(units, factor):
    volume = read(nifti(affine(), affine(), units=units))
    scaled = np.diag([factor] * 3 + [1]) @ affine()
    np.testing.assert_allclose(volume.patient_from_index, LPS_FROM_RAS @ scaled, rtol=1e-5)
    assert volume.origin.notices == ()


@pytest.mark.parametrize(("scale", "kind"), [((2, -1024), np.int16), ((0.5, 3), np.float32)])
def test_a_scale_is_applied(scale, kind):
    volume = read(nifti(affine(), scale=scale))
    np.testing.assert_allclose(volume.voxels, VALUES * scale[0] + scale[1])
    assert volume.voxels.dtype == kind


def test_an_intercept_without_a_slope_is_refused():
    with pytest.raises(BadInput, match="an intercept of 9 and a slope of 0"):
        read(nifti(affine(), scale=(0, 9)))


def test_one_frame_of_a_fourth_axis_is_a_volume_and_several_are_none():
    volume = read(nifti(affine(), frames=1))
    np.testing.assert_array_equal(volume.voxels, VALUES)
    np.testing.assert_allclose(volume.patient_from_index, LPS_FROM_RAS @ affine(), atol=1e-5)
    with pytest.raises(BadInput, match="a size of 3 x 4 x 5 x 2, with 1 values"):
        read(nifti(affine(), frames=2))


def nrrd(*lines):
    head = ["NRRD0004", "type: short", "dimension: 3", "sizes: 3 4 5", "endian: little",
            "encoding: raw", *lines]  # fmt: skip
    return "\n".join([*head, "", ""]).encode() + VALUES.astype("<i2").tobytes(order="F")


AXES = ("space directions: (2,0,0) (0,3,0) (0,0,4)", "space origin: (5,6,7)")


@pytest.mark.parametrize(
    ("space", "signs"),
    [("left-posterior-superior", (1, 1, 1)), ("LPS", (1, 1, 1)), ("RAS", (-1, -1, 1)),
     ("right-anterior-superior", (-1, -1, 1)), ("LAS", (1, -1, 1))],
)  # fmt: skip
def test_nrrd_axes_are_turned_to_lps(space, signs):
    volume = read(nrrd(f"space: {space}", *AXES), "v.nrrd")
    np.testing.assert_array_equal(volume.voxels, VALUES)
    expected = np.diag([*signs, 1]) @ affine()
    np.testing.assert_allclose(volume.patient_from_index, expected)
    assert volume.origin.notices == ()


@pytest.mark.parametrize("lines", [("space: scanner-xyz", *AXES), ("space dimension: 3", *AXES),
                                   ("spacings: 2 3 4",)])  # fmt: skip
def test_an_nrrd_without_an_anatomical_space_is_refused(lines):
    with pytest.raises(BadInput, match="names no anatomical space"):
        read(nrrd(*lines), "v.nrrd")


@pytest.mark.parametrize(("units", "fine"), [('"mm" "mm" "mm"', True), ('"cm" "cm" "cm"', False)])
def test_an_nrrd_in_other_units_than_mm_is_refused(units, fine):
    content = nrrd("space: LPS", *AXES, f"space units: {units}")
    if fine:
        assert read(content, "v.nrrd").voxels.shape == SHAPE
    else:
        with pytest.raises(BadInput, match="not mm"):
            read(content, "v.nrrd")


def meta(*lines):
    head = ["ObjectType = Image", "NDims = 3", "BinaryData = True",
            "BinaryDataByteOrderMSB = False", *lines, "ElementSpacing = 2 3 4", "DimSize = 3 4 5",
            "ElementType = MET_SHORT", "ElementDataFile = LOCAL"]  # fmt: skip
    return "\n".join([*head, ""]).encode() + VALUES.astype("<i2").tobytes(order="F")


def test_the_matrix_of_a_metaimage_counts_and_not_the_letters_beside_it():
    lines = ("TransformMatrix = -1 0 0 0 -1 0 0 0 1", "Offset = 5 6 7")
    for letters in ("RAI", "LPI", "???"):
        volume = read(meta(*lines, f"AnatomicalOrientation = {letters}"), "v.mha")
        np.testing.assert_array_equal(volume.voxels, VALUES)
        np.testing.assert_allclose(volume.patient_from_index, np.diag([-1, -1, 1, 1]) @ affine(
            origin=(-5, -6, 7)))  # fmt: skip
        assert volume.origin.notices == ()


def test_a_metaimage_without_axes_is_taken_for_lps_with_notice():
    volume = read(meta("Offset = 5 6 7"), "v.mha")
    np.testing.assert_allclose(volume.patient_from_index, affine())
    assert volume.origin.notices == (
        "the header gives no axes: left, posterior, superior are assumed",
    )


@pytest.mark.parametrize("name", ["brain.mgz", "a/b.MGH", "scan.img", "scan.mnc"])
def test_volumes_of_other_kinds_are_named_by_their_ending(name):
    ending = name[name.index(".") :].lower()
    with pytest.raises(BadInput, match=rf"1 files, among them \{ending}") as caught:
        ImageFilesFormat.decode({name: b"\x00\x00\x00\x01" * 100})
    assert "NIfTI" in caught.value.cure and "brain" not in str(caught.value)


def test_nothing_that_itk_prints_names_the_file(capfd):
    """It warns of a strange sform, with the path; a file's name may be a patient's."""
    strange = nifti(affine(), affine(), spacing=(1, 1, 1))
    for name, content in {"DOE_JANE.nii": strange, "DOE_JANE.mha": b"NDims = 3"}.items():
        with suppress(BadInput):
            read(content, name)
    printed = capfd.readouterr()
    assert printed.out == printed.err == ""
