"""Data inside a page: JSON that cannot end its script element, and arrays as base64.

A scene is JSON with a list of objects and a list of buffers. An array in an object names its
buffer, its element type and the numbers in each item; quantised arrays add origin and step, so
that `value = origin + step * stored`. All buffers are little-endian.
"""

from base64 import b64encode
from json import dumps, loads
from re import Match, sub

import numpy as np
from jaxtyping import Float, Int

BUFFER_TYPES = {"uint8": "|u1", "uint16": "<u2", "uint32": "<u4", "float32": "<f4"}
"""Element types that the viewers read (names of numpy and of JavaScript's typed arrays)."""


def embed_json(value: object) -> str:
    """Return `value` as JSON that is safe inside a script element.

    Without "<" no "</script" and no "<!--" can stand in it (HTML standard, 4.12.1.3).
    """
    text = dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def share_buffers(fragments: tuple[str, ...]) -> tuple[str, ...]:
    """Return the fragments of one page in which each buffer stands once.

    Where a scene has the buffer of one before it on the page, it says "=2.5" instead: that of scene
    2, buffer 5, both counted from 0. "=" begins no base64.
    """
    known: dict[str, str] = {}
    scene = -1

    def share(found: Match[str]) -> str:
        nonlocal scene
        scene += 1
        buffers = loads(found[1])
        places = (known.setdefault(data, f"={scene}.{n}") for n, data in enumerate(buffers))
        own = f"={scene}."
        shared = [
            data if place.startswith(own) else place
            for data, place in zip(buffers, places, strict=True)
        ]
        return f'"buffers":{embed_json(shared)}'

    return tuple(sub(r'"buffers":(\[[^\]]*\])', share, fragment) for fragment in fragments)


def encode_base64(data: bytes) -> str:
    """Return `data` as base64 text."""
    return b64encode(data).decode("ascii")


def add_array(buffers: list[str], array: np.ndarray, kind: str) -> dict[str, object]:
    """Append an (n, items) array to `buffers` and return what a viewer needs to read it."""
    buffers.append(encode_base64(np.ascontiguousarray(array, BUFFER_TYPES[kind]).tobytes()))
    return {"buffer": len(buffers) - 1, "type": kind, "items": array.shape[1]}


def add_points(buffers: list[str], points_mm: Float[np.ndarray, "n 3"]) -> dict[str, object]:
    """Append points as 16-bit steps of their bounding box: 0.008 mm each on half a metre."""
    points = np.asarray(points_mm, float)
    low, high = points.min(axis=0), points.max(axis=0)
    step = np.where(high > low, (high - low) / 65535, 1.0)
    stored = np.rint((points - low) / step)
    return add_array(buffers, stored, "uint16") | {"origin": low.tolist(), "step": step.tolist()}


def add_indices(buffers: list[str], indices: Int[np.ndarray, "n items"]) -> dict[str, object]:
    """Append whole numbers from 0 on as 16 bits where they fit, else 32."""
    return add_array(buffers, indices, "uint16" if indices.max(initial=0) < 65536 else "uint32")
