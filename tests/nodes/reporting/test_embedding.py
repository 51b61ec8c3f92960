from base64 import b64decode
from json import loads

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.reporting.embedding import (
    add_array,
    add_indices,
    add_points,
    embed_json,
    share_buffers,
)


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


BUFFERS = st.lists(st.sampled_from(["AAAA", "AAAB", "/+8=", "QUJD"]), max_size=4)


@given(st.lists(BUFFERS, min_size=1, max_size=5), st.text())
def test_shared_buffers_stand_once_and_are_found_again(scenes, name):
    fragments = tuple(
        f"<p>{n}</p>" + embed_json({"name": name, "buffers": buffers})
        for n, buffers in enumerate(scenes)
    )
    shared = share_buffers(fragments)
    read = [loads(text.split("</p>")[1]) for text in shared]
    first: dict[str, tuple[int, int]] = {}
    for scene, (told, buffers) in enumerate(zip(read, scenes, strict=True)):
        assert told["name"] == name
        for text, data in zip(told["buffers"], buffers, strict=True):
            if text.startswith("="):
                other, buffer = map(int, text[1:].split("."))
                assert other < scene and read[other]["buffers"][buffer] == data
            else:
                assert text == data and first.setdefault(data, (scene, 0))[0] == scene
