"""Point clouds as PLY with a normal and a label for every point: opens in MeshLab and ParaView."""

import json
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from catalog.formats.header_text import origin_from_text, origin_to_text, to_ascii
from catalog.formats.ply_header import add_comments
from nodes.geometry.point_clouds import PointCloud


class PointCloudFormat:
    """`points.ply`, float32 in patient LPS mm, and `points.json` with the names of the labels."""

    @staticmethod
    def encode(value: PointCloud) -> dict[str, bytes]:
        """Return both files of a point cloud."""
        import open3d

        cloud = open3d.t.geometry.PointCloud()
        cloud.point["positions"] = open3d.core.Tensor(value.points_patient_mm.copy())
        cloud.point["normals"] = open3d.core.Tensor(value.normals.copy())
        cloud.point["label"] = open3d.core.Tensor(value.labels[:, None].copy())
        about = {
            "frame": "patient LPS",
            "unit": "mm",
            "names": value.names,
            "origin": origin_to_text(value.origin),
        }
        with TemporaryDirectory() as scratch:
            path = Path(scratch, "points.ply")
            if not open3d.t.io.write_point_cloud(str(path), cloud):
                raise OSError(f"could not write {len(value.labels)} points to the scratch folder")
            content = path.read_bytes()
        labels = tuple(f"label {n} {to_ascii(name)}" for n, name in enumerate(value.names, start=1))
        content = add_comments(content, value.origin, labels)
        return {"points.ply": content, "points.json": json.dumps(about, indent=1).encode()}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> PointCloud:
        """Return the point cloud of `encode`, equal in every field."""
        import open3d

        with TemporaryDirectory() as scratch:
            path = Path(scratch, "points.ply")
            path.write_bytes(files["points.ply"])
            cloud = open3d.t.io.read_point_cloud(str(path))
        about = json.loads(files["points.json"])
        return PointCloud(
            cloud.point["positions"].numpy().astype(np.float32),
            cloud.point["normals"].numpy().astype(np.float32),
            cloud.point["label"].numpy()[:, 0],
            tuple(about["names"]),
            origin_from_text(about["origin"]),
        )
