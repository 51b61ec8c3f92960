"""Point clouds come back as they were, and trimesh reads their points."""

from io import BytesIO

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from catalog.formats.point_cloud import PointCloudFormat
from nodes.geometry.origin import Origin
from nodes.geometry.point_clouds import PointCloud
from tests.catalog.formats.hostile import ORIGINS, TEXTS, assert_same, points


@st.composite
def point_clouds(draw: st.DrawFn) -> PointCloud:
    count = draw(st.integers(1, 6))
    return PointCloud(
        draw(points(count)),
        draw(points(count)),
        draw(hnp.arrays("uint8", count)),
        draw(st.lists(TEXTS, max_size=3).map(tuple)),
        draw(ORIGINS),
    )


@settings(max_examples=50, deadline=None)
@given(point_clouds())
def test_every_field_of_a_point_cloud_comes_back(cloud: PointCloud) -> None:
    back = PointCloudFormat.decode(PointCloudFormat.encode(cloud))
    assert_same(back.points_patient_mm, cloud.points_patient_mm)
    assert_same(back.normals, cloud.normals)
    assert_same(back.labels, cloud.labels)
    assert (back.names, back.origin) == (cloud.names, cloud.origin)


def test_trimesh_reads_points_and_normals() -> None:
    import trimesh

    places = np.array([[1, 2, 3], [-4, 5.5, 6]], "float32")
    normals = np.array([[0, 0, 1], [0, 1, 0]], "float32")
    cloud = PointCloud(places, normals, np.array([1, 2], "uint8"), ("a", "b"), Origin("x"))
    content = PointCloudFormat.encode(cloud)["points.ply"]
    read = trimesh.load(BytesIO(content), file_type="ply")
    np.testing.assert_array_equal(read.vertices, places)
    raw = read.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(raw["label"].ravel(), [1, 2])
    np.testing.assert_array_equal(
        np.stack([raw[n].ravel() for n in ("nx", "ny", "nz")], 1), normals
    )
