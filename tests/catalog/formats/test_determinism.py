"""Equal values give equal bytes, whenever and in whichever process they are written."""

import hashlib
import json
import subprocess
import sys
import time

import numpy as np
import pandas as pd

from catalog.formats.labelmap import LabelMapFormat
from catalog.formats.mesh import MeshFormat
from catalog.formats.page import PageFormat, SectionFormat
from catalog.formats.point_cloud import PointCloudFormat
from catalog.formats.record import RecordFormat
from catalog.formats.table import TableFormat
from catalog.formats.volume import VolumeFormat
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin
from nodes.geometry.point_clouds import PointCloud
from nodes.reporting.artefacts import Page, Section


def written() -> dict[str, dict[str, str]]:
    """Return the hash of every file that one value of each format is written to."""
    origin = Origin("a phantom", True, ("notice é", "other"))
    voxels = np.arange(60).reshape(3, 4, 5)
    corners = np.eye(3, dtype="float32")
    mesh = Mesh(corners, np.array([[0, 1, 2]], "int32"))
    files = {
        "volume": VolumeFormat.encode(Volume(voxels.astype("int16"), np.eye(4), "HU", origin)),
        "labelmap": LabelMapFormat.encode(
            LabelMap(voxels.astype("uint8"), np.eye(4), ("a", "b"), origin)
        ),
        "mesh": MeshFormat.encode(Surfaces((("a", mesh), ("b", mesh)), origin)),
        "point_cloud": PointCloudFormat.encode(
            PointCloud(corners, corners, np.array([1, 2, 1], "uint8"), ("a", "b"), origin)
        ),
        "table": TableFormat.encode(pd.DataFrame({"a": [1.5, np.nan], "b": ["x", "y"]})),
        "record": RecordFormat.encode({"b": 1, "a": [0.1, None]}),
        "section": SectionFormat.encode(Section("t", "<p>", ("w",), ("s",))),
        "page": PageFormat.encode(Page("<!doctype html>")),
    }
    return {
        name: {file: hashlib.sha256(data).hexdigest() for file, data in made.items()}
        for name, made in files.items()
    }


def test_another_second_and_another_process_write_the_same_bytes() -> None:
    first = written()
    time.sleep(1.05)
    assert written() == first
    source = "import json; from tests.catalog.formats.test_determinism import written;"
    words = [sys.executable, "-c", source + "print(json.dumps(written()))"]
    assert json.loads(subprocess.check_output(words).splitlines()[-1]) == first
