"""Sites come to patient LPS mm from each form that people have them in, or are refused."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from catalog.formats.sites import SitesFormat
from nodes.errors import BadInput
from nodes.geometry.sites import Sites
from tests.catalog.formats.hostile import NAMES, ORIGINS

TURN = Rotation.from_euler("xyz", (20, -50, 130), degrees=True).as_matrix()


def text(matrix: np.ndarray) -> bytes:
    return "\n".join(" ".join(f"{x:.18e}" for x in np.atleast_1d(row)) for row in matrix).encode()


def pose(rotation=TURN, place=(10.0, 20.0, 30.0)) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, place
    return matrix


def markups(*points: dict, **more) -> bytes:
    markup = {"type": "Fiducial", "coordinateSystem": "LPS", "coordinateUnits": "mm", **more}
    return json.dumps({"markups": [{**markup, "controlPoints": points}]}).encode()


def refused(files: dict[str, bytes]) -> str:
    with pytest.raises(BadInput) as caught:
        SitesFormat.decode(files)
    return str(caught.value)


def test_text_in_ras_comes_to_lps_and_keeps_the_sites_own_axes():
    """A step along an axis of the site goes the same way in both, seen in the patient."""
    read = SitesFormat.decode({"a/start1.txt": text(pose()), "target.txt": b"1 2\n3"})
    assert (read.pose_names, read.point_names) == (("start1",), ("target",))
    np.testing.assert_allclose(read.points_patient_mm, [[-1, -2, 3]])
    for axis in np.eye(3):
        ras = pose() @ [*axis, 1]
        np.testing.assert_allclose(
            read.patient_from_site[0] @ [*axis, 1], [-ras[0], -ras[1], ras[2], 1]
        )
    assert np.linalg.det(read.patient_from_site[0][:3, :3]) == pytest.approx(1)


@pytest.mark.parametrize(
    "content", [b"1 2 3", b"1\n2\n3\n\n", b"1, 2, 3", b"\xef\xbb\xbf1\r\n2\r\n3"]
)
def test_numbers_may_stand_in_any_lines(content):
    np.testing.assert_allclose(
        SitesFormat.decode({"p.txt": content}).points_patient_mm, [[-1, -2, 3]]
    )


def test_slicers_markups_come_from_the_system_that_they_name():
    point = {"id": "1", "label": "tip", "position": [1.0, 2.0, 3.0], "orientation": [-1, 0, 0]}
    for system, expected in (("LPS", [1, 2, 3]), ("RAS", [-1, -2, 3])):
        read = SitesFormat.decode({"F.mrk.json": markups(point, coordinateSystem=system)})
        assert read.point_names == ("tip",)
        np.testing.assert_allclose(read.points_patient_mm, [expected])


def test_points_without_a_label_are_numbered_and_unplaced_ones_left_out():
    placed = {"position": [1, 2, 3], "positionStatus": "defined"}
    content = markups(placed, {"position": None, "positionStatus": "undefined"}, placed)
    assert SitesFormat.decode({"goal.mrk.json": content}).point_names == ("goal_1", "goal_2")


def test_other_files_are_left_out_and_counted():
    read = SitesFormat.decode(
        {
            "target.txt": b"1 2 3",
            "README.txt": b"of patients",
            "vessels.nii.gz": b"",
            "._t.txt": b"0",
        }
        | {"notes.txt": b"what it is", "a.json": b"{}"}
    )
    assert read.names == ("target",)
    assert read.origin.notices == ("5 files that hold no sites were left out",)


def test_no_file_means_no_sites():
    none = SitesFormat.decode({})
    assert none.names == () and none.places_patient_mm.shape == (0, 3)


SITES = st.builds(
    lambda poses, points, origin: Sites(
        tuple(poses),
        np.array([pose(Rotation.from_rotvec(v).as_matrix(), 99 * v) for v in poses.values()])
        .reshape(-1, 4, 4),
        tuple(points),
        np.array(list(points.values())).reshape(-1, 3),
        origin,
    ),
    st.dictionaries(NAMES, hnp.arrays(float, 3, elements=st.floats(-3, 3)), max_size=3),
    st.dictionaries(
        NAMES.map("p".__add__), hnp.arrays(float, 3, elements=st.floats(-1e3, 1e3)), max_size=3
    ),
    ORIGINS,
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(SITES)
def test_everything_comes_back_from_the_store(sites):
    if len(set(sites.names)) < len(sites.names):
        return
    back = SitesFormat.decode(SitesFormat.encode(sites))
    assert (back.names, back.pose_names, back.origin) == (
        sites.names,
        sites.pose_names,
        sites.origin,
    )
    np.testing.assert_array_equal(back.patient_from_site, sites.patient_from_site)
    np.testing.assert_array_equal(back.points_patient_mm, sites.points_patient_mm)


def test_what_slicer_is_given_lies_in_the_same_places():
    sites = SitesFormat.decode({"start.txt": text(pose()), "target.txt": b"1 2 3"})
    files = SitesFormat.encode(sites)
    seen = SitesFormat.decode({"s.mrk.json": files["sites.mrk.json"]})
    assert seen.point_names == sites.names
    np.testing.assert_array_equal(seen.points_patient_mm, sites.places_patient_mm)
    written = json.loads(files["sites.mrk.json"])["markups"][0]["controlPoints"][0]["orientation"]
    np.testing.assert_array_equal(np.reshape(written, (3, 3)), sites.patient_from_site[0, :3, :3])


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"1 2 nan", "site start: entry 3 of 3 is nan"),
        (b"1 2 inf", "entry 3 of 3 is inf"),
        (b"1 2 Miller", "entry 3 of 3 is no number"),
        (b"1 2", "2 numbers in 1 lines"),
        (b"", "0 numbers in 0 lines"),
        (b"1 2 3 4\n5 6 7 8\n9 10 11 12", "12 numbers in 3 lines"),
        (text(pose(TURN * 1.01)), "is off from a rotation by 0.02"),
        (text(pose(TURN @ np.diag([1, 1, -1]))), "is mirrored"),
        (text(pose().T), "its last line is [10.0, 20.0, 30.0, 1.0]"),
        ("1 2 3".encode("utf-16"), "no text"),
    ],
)
def test_malformed_text_is_refused_and_never_quoted(content, told):
    message = refused({"start.txt": content})
    assert told in message and "Miller" not in message


def test_a_rotation_written_with_four_decimals_is_one():
    rounded = np.round(pose(), 4)
    read = SitesFormat.decode({"start.txt": text(rounded)})
    np.testing.assert_allclose(abs(read.patient_from_site[0]), abs(rounded))


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"{", "no markups"),
        (b"[]", "no markups"),
        (b'{"markups": [{"controlPoints": [{"position": [1, 2, 3]}]}]}', "no markups"),
        (markups({"position": [1, 2, 3], "label": "a"}, coordinateSystem="scanner"), "in scanner"),
        (markups({"position": [1, 2, 3], "label": "a"}, coordinateUnits="cm"), "cm"),
        (markups({"position": [1, 2], "label": "a"}), "site a: 2 coordinates"),
        (markups({"position": [1, 2, "x"], "label": "a"}), "site a: entry 3 of 3 is no number"),
        (markups({"position": [1, 2, True], "label": "a"}), "entry 3 of 3 is"),
        (markups({"label": "a"}), "no markups"),
        (markups(), "1 files, no site in them"),
    ],
)
def test_malformed_markups_are_refused(content, told):
    assert told in refused({"F.mrk.json": content})


@pytest.mark.parametrize("change", [{"frame": "RAS"}, {"points": [["a", [1, 2]]]}, {"poses": None}])
def test_our_own_file_is_refused_where_someone_broke_it(change):
    content = SitesFormat.encode(Sites())["sites.json"]
    broken = json.dumps({**json.loads(content), **change}).encode()
    assert "sites.json is not as expected" in refused({"sites.json": broken})


def test_two_sites_of_one_name_and_folders_without_any_are_refused():
    assert "2 sites are called target" in refused(
        {"a/target.txt": b"1 2 3", "b/target.txt": b"1 2 3"}
    )
    assert "2 files, no site in them" in refused({"LICENSE": b"x", "a.nii.gz": b"x"})
