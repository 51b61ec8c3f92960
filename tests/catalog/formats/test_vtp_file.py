"""Curves in .vtp are read back with the standard XML reader, as the format's document says."""

from xml.etree import ElementTree

import numpy as np
import pytest

from catalog.formats.vtp_file import write_curves

CURVES = [np.array([[0.1, 0, 0], [1 / 3, 0, 1]]), np.array([[5.0, 1, 2], [6, 1, 2], [7, 1e-17, 2]])]


def arrays_of(content: bytes) -> dict[str, np.ndarray]:
    tree = ElementTree.fromstring(content)
    return {
        item.get("Name"): np.array((item.text or "").split(), float)
        for item in tree.iter("DataArray")
    }


def test_points_and_lines_come_out_with_all_digits() -> None:
    told = arrays_of(write_curves(CURVES, {}, []))
    assert (told["Points"].reshape(-1, 3) == np.concatenate(CURVES)).all()
    assert told["connectivity"].tolist() == [0, 1, 2, 3, 4]
    assert told["offsets"].tolist() == [2, 5]


def test_point_data_keep_name_type_and_width() -> None:
    tangents = np.arange(15.0).reshape(5, 3)
    content = write_curves(CURVES, {"rod": np.array([0, 0, 1, 1, 1]), "tangent": tangents}, [])
    assert (arrays_of(content)["tangent"].reshape(-1, 3) == tangents).all()
    kinds = {
        i.get("Name"): i.get("type") for i in ElementTree.fromstring(content).iter("DataArray")
    }
    assert kinds["rod"] == "Int64" and kinds["tangent"] == "Float64"


@pytest.mark.parametrize("curves", [[], [np.empty((0, 3))]])
def test_no_point_is_a_file_too(curves) -> None:
    piece = ElementTree.fromstring(write_curves(curves, {}, [])).find("PolyData/Piece")
    assert piece.get("NumberOfPoints") == "0" and piece.get("NumberOfLines") == str(len(curves))


def test_notes_end_in_zero_and_names_are_escaped() -> None:
    content = write_curves(CURVES, {'a"<b': np.zeros(5)}, ["näh", "x"])
    told = arrays_of(content)
    assert bytes(told["notes"].astype("uint8")) == "näh\0x\0".encode()
    assert 'a"<b' in told
