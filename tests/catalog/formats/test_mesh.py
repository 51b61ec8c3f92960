"""Surfaces come back as they were, and trimesh and open3d read each of their files."""

from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from catalog.formats.mesh import MeshFormat
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin
from tests.catalog.formats.hostile import NAMES, ORIGINS, assert_same, points


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    """Draw any triangles, also none, equal and degenerate ones, and vertices that none uses."""
    count = draw(st.integers(1, 6))
    triangles = hnp.arrays(
        "int32", (draw(st.integers(0, 5)), 3), elements=st.integers(0, count - 1)
    )
    return Mesh(draw(points(count)), draw(triangles))


SURFACES = st.builds(
    Surfaces, st.lists(st.tuples(NAMES, meshes()), min_size=1, max_size=4).map(tuple), ORIGINS
)
TETRAHEDRON = Mesh(
    np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10]], "float32"),
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], "int32"),
)


def check_round_trip(surfaces: Surfaces) -> None:
    back = MeshFormat.decode(MeshFormat.encode(surfaces))
    assert [name for name, _ in back.meshes] == [name for name, _ in surfaces.meshes]
    for (_, one), (_, two) in zip(back.meshes, surfaces.meshes, strict=True):
        assert_same(one.vertices_patient_mm, two.vertices_patient_mm)
        assert_same(one.triangles, two.triangles)
    assert back.origin == surfaces.origin


@settings(max_examples=60, deadline=None)
@given(SURFACES)
def test_every_field_of_surfaces_comes_back(surfaces: Surfaces) -> None:
    check_round_trip(surfaces)


def test_more_than_a_hundred_surfaces_keep_names_and_order() -> None:
    check_round_trip(Surfaces(tuple((f"s {n}", TETRAHEDRON) for n in range(117)), Origin("x")))


def test_surfaces_of_one_name_are_both_kept() -> None:
    check_round_trip(Surfaces((("a", TETRAHEDRON), ("a", TETRAHEDRON)), Origin("x")))


def test_file_names_stay_in_their_folder_and_are_not_hidden() -> None:
    names = ("../up", "a/b", ".hidden", "white space", "..")
    surfaces = Surfaces(tuple((name, TETRAHEDRON) for name in names), Origin("x"))
    for file in MeshFormat.encode(surfaces):
        assert "/" not in file and not file.startswith(".")


def test_trimesh_and_open3d_read_the_same_surface(tmp_path: Path) -> None:
    import open3d
    import trimesh

    (content,) = MeshFormat.encode(Surfaces((("a", TETRAHEDRON),), Origin("é\n%"))).values()
    path = tmp_path / "a.ply"
    path.write_bytes(content)
    body = trimesh.load(path)
    assert body.is_watertight
    assert abs(body.volume - 1000 / 6) < 1e-3
    other = open3d.io.read_triangle_mesh(str(path))
    np.testing.assert_array_equal(np.asarray(other.vertices), TETRAHEDRON.vertices_patient_mm)
    np.testing.assert_array_equal(np.asarray(other.triangles), TETRAHEDRON.triangles)


def test_the_header_tells_3d_slicer_the_axes() -> None:
    (content,) = MeshFormat.encode(Surfaces((("a", TETRAHEDRON),), Origin("x"))).values()
    assert b"\ncomment SPACE=LPS\n" in content.partition(b"end_header")[0]
