from base64 import b64decode
from json import loads

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.reporting.embedding import add_array, add_indices, add_points, embed_json


@given(st.text())
def test_json_keeps_its_text_and_cannot_end_a_script(text):
    embedded = embed_json({"text": text})
    assert loads(embedded) == {"text": text}
    assert not set("<>&") & set(embedded)


def test_json_refuses_what_javascript_cannot_read():
    with pytest.raises(ValueError):
        embed_json({"value": float("nan")})


def test_points_are_kept_to_half_a_step():
    points = np.random.default_rng(1).uniform(-300, 300, (500, 3)).astype(np.float32)
    buffers: list[str] = []
    told = add_points(buffers, points)
    stored = np.frombuffer(b64decode(buffers[told["buffer"]]), "<u2").reshape(-1, 3)
    read = np.array(told["origin"]) + np.array(told["step"]) * stored
    assert np.abs(read - points).max() <= 600 / 65535 / 2 * 1.01


def test_points_in_one_plane_stay_in_it():
    points = np.array([[0, 0, 7], [1, 0, 7], [0, 1, 7]], np.float32)
    buffers: list[str] = []
    told = add_points(buffers, points)
    stored = np.frombuffer(b64decode(buffers[0]), "<u2").reshape(-1, 3)
    assert told["origin"][2] == 7 and not stored[:, 2].any()


@pytest.mark.parametrize(("largest", "kind"), [(65535, "uint16"), (65536, "uint32")])
def test_indices_take_the_bits_that_they_need(largest, kind):
    buffers: list[str] = []
    told = add_indices(buffers, np.array([[0, 1, largest]], np.int32))
    code = {"uint16": "<u2", "uint32": "<u4"}[kind]
    assert told["type"] == kind
    assert np.frombuffer(b64decode(buffers[0]), code).tolist() == [0, 1, largest]


def test_each_array_has_a_buffer_of_its_own():
    buffers: list[str] = []
    first = add_array(buffers, np.ones((2, 3)), "float32")
    second = add_array(buffers, np.zeros((4, 1)), "uint8")
    assert (first["buffer"], second["buffer"]) == (0, 1)
    assert [len(b64decode(text)) for text in buffers] == [24, 4]
