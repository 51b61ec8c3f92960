"""Surfaces as binary PLY, one file a surface: opens in MeshLab, ParaView and 3D Slicer."""

from collections.abc import Mapping
from io import BytesIO

import numpy as np

from catalog.formats.header_text import from_ascii, to_ascii
from catalog.formats.ply_header import add_comments, read_origin
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin


class MeshFormat:
    """`<order>_<name>.ply` for every surface, vertices float32 in patient LPS mm."""

    @staticmethod
    def encode(value: Surfaces) -> dict[str, bytes]:
        """Return one file for each surface, numbered in their order."""
        return {
            f"{order:02d}_{to_ascii(name)}.ply": _write_ply(mesh, value.origin)
            for order, (name, mesh) in enumerate(value.meshes)
        }

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> Surfaces:
        """Return the surfaces of `encode`, equal in every field."""
        names = sorted(files, key=lambda name: int(name.partition("_")[0]))
        meshes = tuple((_surface_name(name), _read_ply(files[name])) for name in names)
        return Surfaces(meshes, read_origin(files[names[0]]))


def _surface_name(file: str) -> str:
    return from_ascii(file.partition("_")[2].removesuffix(".ply"))


def _write_ply(mesh: Mesh, origin: Origin) -> bytes:
    import trimesh

    body = trimesh.Trimesh(mesh.vertices_patient_mm, mesh.triangles, process=False)
    content = trimesh.exchange.ply.export_ply(body, encoding="binary", vertex_normal=False)
    return add_comments(content, origin)


def _read_ply(content: bytes) -> Mesh:
    import trimesh

    fields = trimesh.exchange.ply.load_ply(BytesIO(content), fix_texture=False)
    return Mesh(
        fields["vertices"].astype("float32").reshape(-1, 3),
        np.asarray(fields.get("faces", ())).astype("int32").reshape(-1, 3),  # none: no key
    )
