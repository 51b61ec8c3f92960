"""What PLY files say about themselves; independent readers see places, sides and units aright."""

from pathlib import Path

import numpy as np
import pytest

from catalog.formats.mesh import MeshFormat
from catalog.formats.ply_header import add_comments, read_origin
from catalog.formats.point_cloud import PointCloudFormat
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin
from nodes.geometry.point_clouds import PointCloud

BARE = b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n"
HOSTILE = Origin("comment SPACE=RAS\nend_header", True, ("SPACE=RAS", "é %"))
# A triangle whose corners lie 10 mm to the left, back and above of (1, 2, 3).
CORNERS = np.array([[11, 2, 3], [1, 12, 3], [1, 2, 13]], np.float32)


def header(content: bytes) -> list[str]:
    return content.partition(b"end_header\n")[0].decode("ascii").splitlines()


def test_axes_unit_and_simulation_stand_in_the_header() -> None:
    lines = header(add_comments(BARE, Origin("phantom", True), ("label 1 bone",)))
    assert lines[:2] == ["ply", "format ascii 1.0"]
    for line in ("SPACE=LPS", "unit mm", "simulated yes", "label 1 bone"):
        assert f"comment {line}" in lines
    assert "comment simulated no" in header(add_comments(BARE, Origin("CT")))


def test_no_text_of_an_origin_can_turn_axes_or_end_the_header() -> None:
    content = add_comments(BARE, HOSTILE, ("SPACE=RAS end_header",))
    assert content.count(b"SPACE=") == 1 and content.count(b"end_header") == 1
    assert read_origin(content) == HOSTILE


def surfaces_file() -> bytes:
    mesh = Mesh(CORNERS, np.array([[0, 1, 2]], np.int32))
    (content,) = MeshFormat.encode(Surfaces((("bone", mesh),), HOSTILE)).values()
    return content


def cloud_file() -> bytes:
    normals = np.tile(np.float32([0, 0, 1]), (3, 1))
    labels = np.array([1, 2, 2], np.uint8)
    cloud = PointCloud(CORNERS, normals, labels, ("left_lung", "SPACE=RAS"), HOSTILE)
    return PointCloudFormat.encode(cloud)["points.ply"]


@pytest.mark.parametrize("content", [surfaces_file(), cloud_file()], ids=["surface", "cloud"])
def test_readers_of_others_see_every_point_where_it_is(content: bytes, tmp_path: Path) -> None:
    import open3d
    import trimesh

    path = tmp_path / "a.ply"
    path.write_bytes(content)
    np.testing.assert_array_equal(trimesh.load(path, process=False).vertices, CORNERS)
    points = open3d.io.read_point_cloud(str(path)).points
    np.testing.assert_array_equal(np.asarray(points), CORNERS)
    np.testing.assert_array_equal(read_binary_ply(content)[:, :3], CORNERS)


def read_binary_ply(content: bytes) -> np.ndarray:
    """Read the vertices' numbers by the format's own rules, as MeshLab and VTK do."""
    types = {"float": "<f4", "double": "<f8", "uchar": "u1", "uint8": "u1", "float32": "<f4"}
    head, _, body = content.partition(b"end_header\n")
    lines = [line.split() for line in head.decode("ascii").splitlines()]
    assert ["format", "binary_little_endian", "1.0"] in lines
    at = next(n for n, line in enumerate(lines) if line[:2] == ["element", "vertex"])
    fields = []
    for line in lines[at + 1 :]:
        if line[0] != "property":
            break
        fields.append((line[2], types[line[1]]))
    values = np.frombuffer(body, np.dtype(fields), int(lines[at][2]))
    return np.stack([values[name].astype(float) for name, _ in fields], axis=1)


def test_a_clouds_labels_have_names_in_the_header() -> None:
    lines = header(cloud_file())
    assert "comment label 1 left_lung" in lines
    assert any(line.startswith("comment label 2 ") for line in lines)
