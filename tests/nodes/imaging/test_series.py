"""Which planes belong together, and which series is taken, asked for, or refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.imaging.series import split_series
from nodes.imaging.series_key import series_key
from tests.nodes.imaging.made_planes import PARAMETERS, read, settings_of, stack

UID = "1.2.840.99999.4711"
TURNED = Rotation.from_euler("x", 90, degrees=True).as_matrix()


def test_the_clearly_largest_series_of_the_modality_is_chosen_and_said():
    planes = [
        *stack(range(4), series=1),
        *stack(range(9), series=2),
        *stack(range(30), series=3, modality="MR", unit="intensity"),
    ]
    volume = read(planes)
    assert volume.voxels.shape[2] == 9 and volume.unit == "HU"
    assert volume.origin.notices == ("series 2 of 3 was chosen, the largest (9 planes)",)
    anything = read(planes, modality="any")
    assert anything.voxels.shape[2] == 30 and anything.unit == "intensity"


@pytest.mark.parametrize("counts", [(5, 5), (9, 6), (5, 9, 9)])
def test_without_a_clear_choice_the_series_are_listed_without_identifiers(counts):
    planes = [
        plane
        for number, count in enumerate(counts, start=1)
        for plane in stack(range(count), series=number, series_key=series_key(f"{UID}.{number}"))
    ]
    with pytest.raises(BadInput, match=f"{len(counts)} series and no clear choice") as caught:
        read(planes)
    text = str(caught.value)
    for number, count in enumerate(counts, start=1):
        line = f"{number}: CT, {count} planes of 6 x 4, 0.50 x 0.80 mm, 1.00 mm apart"
        assert line in text
    assert "set the parameter series" in text
    assert "4711" not in text and series_key(f"{UID}.1") not in text


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_how_large_a_rival_may_be_is_a_parameter(share):
    planes = [*stack(range(10), series=1), *stack(range(7), series=2)]
    if share == 0.5:
        with pytest.raises(BadInput, match=r"no other has more than 0.5 of its voxels"):
            read(planes, rival_share=share)
    else:
        assert read(planes, rival_share=share).voxels.shape[2] == 10


@pytest.mark.parametrize("name", [2, "2", f"{UID}.2", series_key(f"{UID}.2")])
def test_a_series_is_found_by_number_uid_and_key(name):
    planes = [
        *stack(range(9), series=1, series_key=series_key(f"{UID}.1")),
        *stack(range(5), series=2, series_key=series_key(f"{UID}.2")),
    ]
    volume = read(planes, series=name)
    assert volume.voxels.shape[2] == 5
    assert volume.origin.notices == ("series 2 of 2 was chosen, as asked (5 planes)",)


@pytest.mark.parametrize("name", [3, f"{UID}.9"])
def test_a_series_that_is_not_there_is_refused_with_what_is(name):
    planes = [*stack(range(9), series=1), *stack(range(5), series=2)]
    with pytest.raises(BadInput, match="no series is named so") as caught:
        read(planes, series=name)
    assert "1: CT, 9 planes" in str(caught.value) and UID not in str(caught.value)


def test_a_missing_modality_is_refused_with_what_there_is():
    with pytest.raises(BadInput, match="modalities found: MR"):
        read(stack(range(3), modality="MR"))


@pytest.mark.parametrize("shape", [(30, 30), (4, 6)])
def test_an_overview_within_the_series_is_left_out_and_said(shape):
    overview = stack([50], shape=shape, kind="original primary localizer")
    planes = overview + stack(range(40), kind="original primary axial")
    volume = read(planes)  # although an overview may have more pixels
    assert volume.voxels.shape == (6, 4, 40)
    assert volume.origin.notices == ("series 2 of 2 was chosen, the largest (40 planes)",)


def test_an_overview_of_several_planes_is_no_rival():
    overviews = stack(range(4), shape=(40, 40), kind="original primary localizer", series=2)
    assert read(overviews + stack(range(8))).voxels.shape == (6, 4, 8)


def test_directions_and_sizes_within_a_series_are_told_apart():
    parts = [
        stack(range(30)),
        stack(range(5), axes=TURNED),
        stack(range(5), shape=(4, 5)),
        stack(range(5), spacing=(0.5, 0.88)),
    ]
    found = split_series(tuple(plane for part in parts for plane in part), PARAMETERS)
    assert [len(series.planes) for series in found] == [30, 5, 5, 5]
    assert read([plane for part in parts for plane in part]).voxels.shape[2] == 30


@settings(max_examples=20, deadline=None)
@given(st.randoms(use_true_random=False), st.sampled_from(["kind", "acquisition"]))
def test_stacks_at_the_same_places_are_told_apart_by_their_marks(random, mark):
    values = ("echo 5 ms", "echo 10 ms") if mark == "kind" else (1, 2)
    planes = [plane for value in values for plane in stack(range(6), **{mark: value})]
    random.shuffle(planes)
    with pytest.raises(BadInput, match="2 series and no clear choice"):
        read(planes)
    first = 1 + (values[0] != vars(planes[0])[mark])
    chosen = read(planes, series=first)
    assert chosen.voxels.shape[2] == 6


def test_acquisitions_are_told_apart_also_where_each_plane_has_a_moment_of_its_own():
    planes = [
        replace(plane, kind=f"trigger {10 * number} ms", acquisition=acquisition)
        for acquisition in (1, 2)
        for number, plane in enumerate(stack(range(6)))
    ]
    assert [len(found.planes) for found in split_series(tuple(planes), PARAMETERS)] == [6, 6]


def test_marks_that_do_not_undouble_every_plane_split_nothing():
    """Four monitor scans at one place, and a series that was sent twice."""
    monitor = [replace(stack([61.5])[0], acquisition=number) for number in (12, 13, 14, 15)]
    with pytest.raises(BadInput, match="4 planes at one place"):
        read(monitor)
    with pytest.raises(BadInput, match="two planes at one place"):
        read([*stack(range(6)), *stack(range(6))])


def test_acquisitions_that_continue_each_other_stay_one_stack():
    planes = [replace(plane, acquisition=n) for n, plane in enumerate(stack(range(8)))]
    volume = read(planes)
    assert volume.voxels.shape[2] == 8 and volume.origin.notices == ()


def test_an_orientation_that_only_trembles_is_one_stack():
    axes = Rotation.from_euler("xyz", [0.03, 0.02, 0.01], degrees=True).as_matrix()
    planes = stack(range(8), axes=np.eye(3))
    planes[3] = stack([3], axes=axes)[0]
    assert len(split_series(tuple(planes), settings_of(orientation_tolerance_deg=0.1))) == 1
    assert len(split_series(tuple(planes), settings_of(orientation_tolerance_deg=0.01))) == 2
