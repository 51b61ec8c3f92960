"""Curves as VTK XML PolyData (.vtp), which ParaView and 3D Slicer open.

Written in the format's ASCII kind (VTK's file formats, docs.vtk.org): every number with all its
digits, and readable by eye; no package that writes it is worth its size here.
"""

from collections.abc import Mapping, Sequence
from xml.sax.saxutils import quoteattr

import numpy as np


def write_curves(
    curves: Sequence[np.ndarray], point_data: Mapping[str, np.ndarray], notes: Sequence[str]
) -> bytes:
    """Return a file of open curves.

    Parameters
    ----------
    curves : (n, 3) points of each.
    point_data : values at all points in the order of the curves, (all,) or (all, 3), by name.
    notes : texts that a reader must know; kept as field data, where ParaView shows them.
    """
    points = np.concatenate([np.empty((0, 3)), *curves])
    ends = np.cumsum([len(curve) for curve in curves], dtype=np.int64)
    arrays = "".join(_array(name, values) for name, values in point_data.items())
    lines = _array("connectivity", np.arange(len(points))) + _array("offsets", ends)
    piece = (
        f'<Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" NumberOfLines="{len(ends)}"'
        ' NumberOfStrips="0" NumberOfPolys="0">\n'
        f"<PointData>\n{arrays}</PointData>\n"
        f"<Points>\n{_array('Points', points)}</Points>\n<Lines>\n{lines}</Lines>\n</Piece>\n"
    )
    told = f"<FieldData>\n{_texts('notes', notes)}</FieldData>\n" if notes else ""
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="0.1"'
        ' byte_order="LittleEndian">\n'
        f"<PolyData>\n{told}{piece}</PolyData>\n</VTKFile>\n"
    )
    return text.encode("ascii")


def _array(name: str, values: np.ndarray) -> str:
    whole = values.dtype.kind in "iu"
    width = values.shape[1] if values.ndim == 2 else 1
    rows = values.reshape(-1, width).tolist()
    body = "\n".join(" ".join(map(repr, row)) for row in rows)
    return (
        f'<DataArray type="{"Int64" if whole else "Float64"}" Name={quoteattr(name)}'
        f' NumberOfComponents="{width}" format="ascii">\n{body}\n</DataArray>\n'
    )


def _texts(name: str, texts: Sequence[str]) -> str:
    """Return texts as the codes of their bytes, each ended by 0, as the format wants them."""
    codes = " ".join(str(code) for text in texts for code in [*text.encode("utf-8"), 0])
    return (
        f'<DataArray type="String" Name={quoteattr(name)} NumberOfTuples="{len(texts)}"'
        f' format="ascii">\n{codes}\n</DataArray>\n'
    )
