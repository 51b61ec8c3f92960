import json
import re
import time
from base64 import b64decode
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin
from nodes.reporting.show_slices import show_slices
from nodes.reporting.show_volume import show_volume


def header_of(section):
    text = re.search(r'<script type="application/json">(.*?)</script>', section.html, re.S).group(1)
    return json.loads(text)


def voxels_of(section, kind):
    """Read a mosaic back into voxels, as the viewer does."""
    data = re.search(rf'class="{kind}".*?base64,([^"]*)"', section.html).group(1)
    picture = np.array(Image.open(BytesIO(b64decode(data))).convert("L"))
    header = header_of(section)
    (ni, nj, nk), tiles = header["shape"], header["tiles"]
    voxels = np.empty((ni, nj, nk), np.uint8)
    for k in range(nk):
        row, column = divmod(k, tiles["columns"])
        tile = picture[row * tiles["height"] :, column * tiles["width"] :]
        voxels[:, :, k] = tile[:nj, :ni].T
    return voxels


def test_labels_arrive_exactly(box_with_ball, defaults):
    volume, label_map = box_with_ball
    section = show_slices(volume, label_map, defaults("show_slices"))
    labels = voxels_of(section, "labels") / header_of(section)["label_step"]
    assert np.array_equal(labels, label_map.voxels)


def test_255_labels_arrive_exactly(box_with_ball, defaults):
    volume, _ = box_with_ball
    voxels = (np.arange(volume.voxels.size) % 256).astype(np.uint8).reshape(volume.voxels.shape)
    names = tuple(f"part_{n}" for n in range(255))
    label_map = LabelMap(voxels, volume.patient_from_index, names, Origin("stripes"))
    section = show_slices(volume, label_map, defaults("show_slices"))
    assert header_of(section)["label_step"] == 1
    assert np.array_equal(voxels_of(section, "labels"), voxels)


def test_soft_tissue_is_told_from_fat_and_fluid(defaults):
    i = np.indices((60, 60, 4))[0]
    hu = np.select([i < 20, i < 40], [-90, 10], 60).astype(np.int16)
    section = show_volume(Volume(hu, np.eye(4), "HU", Origin("layers")), defaults("show_volume"))
    header, grey = header_of(section), voxels_of(section, "grey")
    shown = np.interp(grey, header["greys"], header["knots"])
    for middle, expected in ((10, -90), (30, 10), (50, 60)):
        assert abs(np.median(shown[middle]) - expected) <= 5


def test_volume_is_shown_with_the_patients_axes(box_with_ball, defaults):
    volume, label_map = box_with_ball
    turned = np.ascontiguousarray(label_map.voxels[::-1].transpose(2, 0, 1))
    index_from_turned = np.array([[0, -1, 0, 47], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
    patient_from_turned = volume.patient_from_index @ index_from_turned
    other = LabelMap(turned, patient_from_turned, label_map.names, label_map.origin)
    ct = Volume(
        np.ascontiguousarray(volume.voxels[::-1].transpose(2, 0, 1)),
        patient_from_turned,
        "HU",
        volume.origin,
    )
    section = show_slices(ct, other, defaults("show_slices"))
    labels = voxels_of(section, "labels") // header_of(section)["label_step"]
    assert np.array_equal(labels, label_map.voxels)
    assert np.allclose(header_of(section)["patient_from_index"], volume.patient_from_index)


def test_intensities_span_the_greys_from_least_to_greatest(defaults):
    mri = np.linspace(5, 905, 32 * 32 * 16, dtype=np.float32).reshape(32, 32, 16)
    section = show_volume(
        Volume(mri, np.eye(4), "intensity", Origin("ramp")), defaults("show_volume")
    )
    header = header_of(section)
    assert header["knots"] == [5, 905] and header["greys"] == [0, 255]
    full = header["windows"][1]
    assert full["level"] == pytest.approx(455) and full["width"] == pytest.approx(900)


def test_a_constant_volume_can_be_shown(defaults):
    zeros = Volume(np.zeros((20, 20, 5), np.float32), np.eye(4), "intensity", Origin("nothing"))
    assert header_of(show_volume(zeros, defaults("show_volume")))["windows"][0]["width"] > 0


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_labels_on_another_grid_are_refused(box_with_ball, defaults, axis):
    volume, label_map = box_with_ball
    moved = label_map.patient_from_index.copy()
    moved[axis, 3] += 0.5
    with pytest.raises(BadInput, match="one grid"):
        show_slices(volume, replace(label_map, patient_from_index=moved), defaults("show_slices"))


def test_a_volume_without_voxels_is_refused(defaults):
    empty = Volume(np.zeros((0, 4, 4), np.int16), np.eye(4), "HU", Origin("nothing"))
    with pytest.raises(BadInput):
        show_volume(empty, defaults("show_volume"))


def test_both_origins_warn(box_with_ball, defaults):
    volume, label_map = box_with_ball
    guessed = replace(label_map, origin=Origin("a phantom", True, ("Guessed.",)))
    section = show_slices(volume, guessed, defaults("show_slices"))
    assert section.warnings == ("simulated: a phantom", "Guessed.")


def test_a_chest_ct_takes_seconds_and_few_megabytes(test_data, defaults):
    import SimpleITK

    folder = test_data / "chest_ct" / "P002"
    if not folder.is_dir():
        pytest.skip("chest_ct/P002 is not there")
    names = SimpleITK.ImageSeriesReader.GetGDCMSeriesFileNames(str(folder))
    voxels = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(names)).transpose(2, 1, 0)
    hu = np.ascontiguousarray(voxels, np.int16)
    labels = np.select([hu > 200, hu > -400, hu > -950], [3, 1, 2], 0).astype(np.uint8)
    grid = np.diag([0.6, 0.6, 2.0, 1.0])
    volume = Volume(hu, grid, "HU", Origin("P002"))
    label_map = LabelMap(labels, grid, ("body", "lungs", "bone"), Origin("thresholds"))
    start = time.perf_counter()
    section = show_slices(volume, label_map, defaults("show_slices"))
    assert time.perf_counter() - start < 8  # 2.5 s on a free machine
    assert len(section.html) < 2.5e6
