"""What files say of their planes: enhanced ones frame by frame, and no identifier."""

from io import BytesIO

import numpy as np
import pydicom
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.image_files import ImageFilesFormat
from nodes.errors import BadInput
from nodes.imaging.artefacts import ImageFiles
from nodes.imaging.read_volume import read_volume
from nodes.imaging.series_key import series_key
from tests.catalog.formats.enhanced import decode, enhanced_file, planes
from tests.nodes.imaging.made_planes import settings_of

HU = {"PixelValueTransformationSequence": {
    "RescaleSlope": 1, "RescaleIntercept": 0, "RescaleType": "HU"}}  # fmt: skip
ANYWHERE = ["PlaneOrientationSequence", "PixelMeasuresSequence"]


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 6), st.sets(st.sampled_from(ANYWHERE)), st.integers(0, 99))
def test_every_frame_becomes_a_plane_with_its_own_place(count, share, seed):
    made = planes(count, seed=seed)
    read = decode(enhanced_file(made, shared=HU, share=share))
    assert len(read) == count
    for one, other in zip(read, made, strict=True):
        np.testing.assert_array_equal(one.pixels, other.pixels)
        np.testing.assert_allclose(one.patient_from_pixel, other.patient_from_pixel, atol=1e-7)
        assert (one.unit, one.modality, one.series) == ("HU", "CT", 1)


def test_each_frame_has_its_own_scale():
    made = planes(3, modality="MR")
    scales = [(2.0, 5.0), (0.5, -3.0), (1.0, 0.0)]
    further = [
        {"PixelValueTransformationSequence": {
            "RescaleSlope": slope, "RescaleIntercept": intercept, "RescaleType": "US"}}
        for slope, intercept in scales
    ]  # fmt: skip
    for plane, original, (slope, intercept) in zip(
        decode(enhanced_file(made, further)), made, scales, strict=True
    ):
        np.testing.assert_allclose(plane.pixels, original.pixels * slope + intercept)
        assert plane.unit == "intensity"


@pytest.mark.parametrize(("kind", "unit"), [("HU", "HU"), ("US", "intensity"), (None, "HU")])
def test_a_ct_is_hu_unless_the_type_of_its_scale_says_otherwise(kind, unit):
    scale = {"RescaleSlope": 1, "RescaleIntercept": -1024}
    scale |= {"RescaleType": kind} if kind else {}
    made = planes(2)
    read = decode(enhanced_file(made, shared={"PixelValueTransformationSequence": scale}))
    assert {plane.unit for plane in read} == {unit}


def test_a_whole_enhanced_file_is_one_volume_with_frames_in_any_order():
    made = planes(6)
    volume = read_volume(
        ImageFilesFormat.decode({"a": enhanced_file([made[k] for k in (3, 0, 5, 1, 4, 2)],
                                                    shared=HU)}),
        settings_of(),
    )  # fmt: skip
    expected = np.stack([plane.pixels.T for plane in made], axis=2)
    np.testing.assert_array_equal(volume.voxels, np.maximum(expected, -1024))


@pytest.mark.parametrize(
    ("sequence", "keyword", "values", "words"),
    [
        ("MREchoSequence", "EffectiveEchoTime", (5.0, 10.0), "echo 10 ms"),
        ("FrameContentSequence", "TemporalPositionIndex", (1, 2), "moment 2"),
        ("FrameContentSequence", "StackID", ("1", "2"), "stack 2"),
        ("MRDiffusionSequence", "DiffusionBValue", (0.0, 800.0), "b 800"),
        ("MRImageFrameTypeSequence", "FrameType", (["ORIGINAL"], ["DERIVED"]), "derived"),
    ],
)
def test_stacks_within_one_enhanced_file_are_told_apart(sequence, keyword, values, words):
    made = planes(5, modality="MR")
    content = enhanced_file(
        [*made, *made], [{sequence: {keyword: value}} for value in values for _ in made]
    )
    with pytest.raises(BadInput, match="2 series and no clear choice") as caught:
        read_volume(ImageFiles(decode(content)), settings_of(modality="MR"))
    assert words in str(caught.value)
    chosen = read_volume(ImageFiles(decode(content)), settings_of(modality="MR", series=2))
    np.testing.assert_array_equal(chosen.voxels[:, :, 0].T, made[0].pixels)


def test_private_groups_do_not_move_a_frame():
    """Philips repeats position and scale there, for another pixel's corner."""
    dataset = pydicom.dcmread(BytesIO(enhanced_file(planes(3))))
    for frame in dataset.PerFrameFunctionalGroupsSequence:
        inner = pydicom.Dataset()
        inner.ImagePositionPatient, inner.RescaleSlope = [9, 9, 9], 77
        block = frame.private_block(0x2005, "Philips MR Imaging DD 005", create=True)
        block.add_new(0x0F, "SQ", pydicom.Sequence([inner]))
    file = BytesIO()
    dataset.save_as(file)
    for one, other in zip(decode(file.getvalue()), planes(3), strict=True):
        np.testing.assert_allclose(one.patient_from_pixel, other.patient_from_pixel, atol=1e-7)
        np.testing.assert_array_equal(one.pixels, other.pixels)


@pytest.mark.parametrize(
    "change",
    [{"SamplesPerPixel": 3, "PhotometricInterpretation": "RGB"}, {"Modality": "SEG"},
     {"PhotometricInterpretation": "PALETTE COLOR"}],
)  # fmt: skip
def test_colours_and_masks_are_no_planes(change):
    made = planes(3, shape=(6, 6))
    content = enhanced_file(made[:1] * 3, **change)
    with pytest.raises(BadInput):
        decode(content)


def test_one_place_that_all_frames_share_piles_them_up():
    content = enhanced_file(planes(3), share=["PlanePositionSequence"])
    with pytest.raises(BadInput, match="3 planes at one place"):
        read_volume(ImageFiles(decode(content)), settings_of(hu_offset=0))


@pytest.mark.parametrize("top", [{}, {"ImagePositionPatient": [1, 2, 3]}])
def test_frames_without_a_place_are_skipped_even_if_the_top_gives_one(top):
    content = enhanced_file(planes(3), share=["PlanePositionSequence"], **top)
    dataset = pydicom.dcmread(BytesIO(content))
    del dataset.SharedFunctionalGroupsSequence[0].PlanePositionSequence
    file = BytesIO()
    dataset.save_as(file)
    again = ImageFilesFormat.decode({"a": file.getvalue(), "b": enhanced_file(planes(4))})
    assert len(again.slices) == 4 and again.skipped == 1


def test_no_identifier_and_no_free_text_leaves_an_enhanced_file():
    further = [
        {"FrameContentSequence": {"StackID": "DOE^JANE", "FrameComments": "born 1901"},
         "MRImageFrameTypeSequence": {"FrameType": ["ORIGINAL", "JANE DOE"]}}
        for _ in range(3)
    ]  # fmt: skip
    slices = decode(enhanced_file(planes(3, modality="MR"), further))
    text = repr(slices)
    assert not any(word in text for word in ("DOE", "doe", "1901", "SECRET", "2.25.8"))
    assert slices[0].series_key == series_key("2.25.8")
    assert slices[0].kind.startswith("original s")


def test_words_that_cannot_be_read_do_not_spoil_a_plane():
    content = enhanced_file(planes(3)).replace(b"ORIGINAL", b"\xff\xfe^\\^^^^")
    assert len(decode(content)) == 3
