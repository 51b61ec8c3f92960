"""Large tables of points as VTK XML PolyData (.vtp) with binary numbers, read back bit by bit.

VTK's appended raw kind (VTK's file formats, docs.vtk.org): a head of text says what each array is
and where it begins; the numbers follow as they lie in memory. ParaView and 3D Slicer open it, and a
million points take a second.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np

_START = b'<AppendedData encoding="raw">\n_'
_END = b"\n</AppendedData>\n</VTKFile>\n"
_KINDS = {
    f"{name}{8 * size}": np.dtype(f"<{kind}{size}")
    for kind, name, sizes in (
        ("i", "Int", (1, 2, 4, 8)), ("u", "UInt", (1, 2, 4, 8)), ("f", "Float", (4, 8)),
    )
    for size in sizes
}  # fmt: skip
_NAMES = {kind: name for name, kind in _KINDS.items()}


class PointTable(NamedTuple):
    """Points and what is told of each.

    Parameters
    ----------
    points : (n, 3).
    columns : values at all points, (n,) or (n, width), by name.
    fields : arrays of any length, (m,) or (m, width), by name.
    """

    points: np.ndarray
    columns: Mapping[str, np.ndarray]
    fields: Mapping[str, np.ndarray]


def write_points(table: PointTable, lines: np.ndarray, notes: Sequence[str]) -> bytes:
    """Return the file.

    Parameters
    ----------
    lines : (line, 2) from which point to which; points in none are drawn as points.
    notes : texts that a reader must know; kept as field data, where ParaView shows them.
    """
    data = _Data()
    alone = np.setdiff1d(np.arange(len(table.points)), lines)
    piece = (
        f'<Piece NumberOfPoints="{len(table.points)}" NumberOfVerts="{len(alone)}"'
        f' NumberOfLines="{len(lines)}" NumberOfStrips="0" NumberOfPolys="0">\n'
        f"<PointData>\n{data.add_all(table.columns)}</PointData>\n"
        f"<Points>\n{data.add('Points', table.points)}</Points>\n"
        f"<Verts>\n{data.add_cells(alone[:, None])}</Verts>\n"
        f"<Lines>\n{data.add_cells(lines)}</Lines>\n</Piece>\n"
    )
    fields = data.add_all(table.fields) + data.add_texts("notes", notes)
    head = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"'
        f' header_type="UInt64">\n<PolyData>\n<FieldData>\n{fields}</FieldData>\n{piece}'
        "</PolyData>\n"
    )
    return b"".join([head.encode("ascii", "xmlcharrefreplace"), _START, *data.parts, _END])


def read_points(content: bytes) -> PointTable:
    """Return the table of `write_points`; arrays of one number a row are (n,)."""
    head, _, data = content.partition(_START)
    tree = ElementTree.fromstring(head + b"</VTKFile>")
    points, columns, fields = (
        {item.get("Name", ""): _read(item, data) for item in tree.findall(f"PolyData/{place}/*")}
        for place in ("Piece/Points", "Piece/PointData", "FieldData")
    )
    fields.pop("notes")
    return PointTable(points["Points"], columns, fields)


def _read(item: ElementTree.Element, data: bytes) -> np.ndarray:
    if item.get("type") == "String":
        return np.empty(0)
    start, kind = int(item.get("offset", "")), _KINDS[item.get("type", "")]
    size, width = int.from_bytes(data[start : start + 8], "little"), item.get("NumberOfComponents")
    values = np.frombuffer(data, kind, size // kind.itemsize, start + 8)
    return values if width == "1" else values.reshape(-1, int(width or 1))


class _Data:
    """The binary part: arrays one after the other, each after its size in bytes."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0

    def add_all(self, arrays: Mapping[str, np.ndarray]) -> str:
        return "".join(self.add(name, values) for name, values in arrays.items())

    def add(self, name: str, values: np.ndarray) -> str:
        """Append an array; return its line in the head."""
        kind = _NAMES[values.dtype.newbyteorder("<")]
        width = values.shape[1] if values.ndim == 2 else 1
        return self._append(
            f'type="{kind}" Name={quoteattr(name)} NumberOfComponents="{width}"'
            f' NumberOfTuples="{len(values)}"',
            values.astype(_KINDS[kind], copy=False).tobytes(),
        )

    def add_cells(self, cells: np.ndarray) -> str:
        """Append the points of each cell, (cell, points)."""
        ends = np.arange(1, len(cells) + 1, dtype=np.int64) * cells.shape[1]
        connectivity = cells.ravel().astype(np.int64)
        return self.add("connectivity", connectivity) + self.add("offsets", ends)

    def add_texts(self, name: str, texts: Sequence[str]) -> str:
        """Append texts, each ended by 0, as the format wants them."""
        content = b"".join(text.encode("utf-8").replace(b"\0", b" ") + b"\0" for text in texts)
        head = f'type="String" Name={quoteattr(name)} NumberOfTuples="{len(texts)}"'
        return self._append(head, content)

    def _append(self, head: str, content: bytes) -> str:
        line = f'<DataArray {head} format="appended" offset="{self.size}"/>\n'
        self.parts += [len(content).to_bytes(8, "little"), content]
        self.size += 8 + len(content)
        return line
