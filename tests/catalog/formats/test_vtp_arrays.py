"""Binary .vtp files come back bit by bit, and lie as VTK's document says."""

from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from catalog.formats.vtp_arrays import PointTable, read_points, write_points

KINDS = ["int8", "uint8", "int32", "int64", "uint64", "float32", "float64"]


@given(st.integers(0, 4), st.data())
def test_arrays_of_every_kind_come_back_bit_by_bit(count: int, data: st.DataObject) -> None:
    columns = {
        f"{kind} {width}": data.draw(hnp.arrays(kind, (count, width) if width > 1 else count))
        for kind in KINDS
        for width in (1, 3)
    }
    fields = {'a "field" <x>': data.draw(hnp.arrays("int64", st.integers(0, 5)))}
    points = data.draw(hnp.arrays(float, (count, 3)))
    told = PointTable(points, columns, fields)
    back = read_points(write_points(told, np.empty((0, 2), np.int64), ["é", ""]))
    assert back.points.tobytes() == points.tobytes()
    for given_, found in ((columns, back.columns), (fields, back.fields)):
        assert list(given_) == list(found)
        for name, values in given_.items():
            assert found[name].dtype == values.dtype and found[name].shape == values.shape
            assert found[name].tobytes() == values.tobytes()


def test_each_array_begins_where_the_head_says_after_its_size_in_bytes() -> None:
    points = np.arange(9.0).reshape(3, 3)
    table = PointTable(points, {"depth": np.array([7, 8, 9], np.int32)}, {})
    content = write_points(table, np.array([[0, 2]]), ["seen"])
    head, _, data = content.partition(b'<AppendedData encoding="raw">\n_')
    assert data.endswith(b"\n</AppendedData>\n</VTKFile>\n")
    tree = ElementTree.fromstring(head + b"</VTKFile>")
    assert tree.get("header_type") == "UInt64" and tree.get("byte_order") == "LittleEndian"
    found = {}
    for item in tree.iter("DataArray"):
        start = int(item.get("offset"))
        size = int(np.frombuffer(data, "<u8", 1, start)[0])
        found.setdefault(item.get("Name"), []).append(data[start + 8 : start + 8 + size])
    assert np.frombuffer(found["Points"][0]).tolist() == list(range(9))
    assert np.frombuffer(found["depth"][0], "<i4").tolist() == [7, 8, 9]
    assert found["notes"] == [b"seen\0"]
    vertices, lines = (np.frombuffer(each, "<i8").tolist() for each in found["connectivity"])
    assert (vertices, lines) == ([1], [0, 2])
    assert [np.frombuffer(each, "<i8").tolist() for each in found["offsets"]] == [[1], [2]]


def test_bytes_of_another_byte_order_are_turned_round() -> None:
    table = PointTable(np.zeros((2, 3)), {"a": np.array([1, 2], ">i4")}, {})
    back = read_points(write_points(table, np.empty((0, 2), np.int64), []))
    assert back.columns["a"].tolist() == [1, 2]


@pytest.mark.parametrize("text", ["</AppendedData>", "<x> & _"])
def test_notes_cannot_break_the_file(text: str) -> None:
    table = PointTable(np.zeros((1, 3)), {}, {"x": np.arange(3)})
    back = read_points(write_points(table, np.empty((0, 2), np.int64), [text]))
    assert back.fields["x"].tolist() == [0, 1, 2]
