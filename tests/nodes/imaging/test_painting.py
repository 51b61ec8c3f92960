"""Painting: shares against closed forms and against brute force on a three times finer grid."""

import numpy as np
import pytest

from nodes.imaging.painting import Canvas, paint
from nodes.imaging.solids import box, cut, ellipsoid, shell, tube

SPACINGS = [(1.0, 1.0, 1.0), (0.7, 0.7, 3.0), (2.0, 1.0, 5.0)]


def blank(spacing, extent=36.0, parts=1, bend=lambda points: points):
    """An empty canvas around the origin, or the same volume with each voxel cut in parts^3."""
    counts = [int(extent / step) for step in spacing]
    axes = []
    for count, step in zip(counts, spacing, strict=True):
        fine = (np.arange(count * parts) - (count * parts - 1) / 2) * step / parts
        axes.append(fine.astype(np.float32))
    shape = tuple(count * parts for count in counts)
    hu, labels = np.zeros(shape, np.float32), np.zeros(shape, np.uint8)
    return Canvas(tuple(axes), tuple(step / parts for step in spacing), bend, hu, labels)


def averaged(values, parts):
    a, b, c = (n // parts for n in values.shape)
    return values.reshape(a, parts, b, parts, c, parts).mean(axis=(1, 3, 5))


SOLIDS = {
    "egg": [ellipsoid((0.3, 0.2, -0.4), (9, 14, 12))],
    "sheet": [
        cut([shell(ellipsoid((0, 0, 0), (14, 14, 14)), 0.8), box((5, 0.4, 1.1), (20, 9, 9))])
    ],
    "tube": tube(np.array([(-12.0, -3, -5), (0, 8, 3), (10, 8, -6)]), 2.5, 1.6),
    "thin tube": tube(np.array([(-12.0, -3, -5), (10, 8, 6)]), 1.0),
}


@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("name", SOLIDS)
def test_a_voxel_holds_the_mean_of_what_is_in_it(name, spacing):
    """Brute force: hard voxels on a grid eight times finer."""
    canvas, fine = blank(spacing), blank(spacing, parts=8)
    paint(canvas, SOLIDS[name], 1000.0, 7)
    x, y, z = np.meshgrid(*fine.axes, indexing="ij", sparse=True)
    inside = np.zeros(fine.hu.shape, bool)
    for solid in SOLIDS[name]:
        inside |= solid.distance((x, y, z)) < 0
    truth = averaged(inside.astype(np.float32), 8) * 1000
    error = canvas.hu - truth
    # Edges are ramps as wide as a part w: a tube of radius r grows by w^2 / (12 r^2), and the rim
    # of a sheet is rounded; that shows in what is about as thin as a part.
    assert abs(error.sum()) < (0.08 if name in ("thin tube", "sheet") else 0.02) * truth.sum()
    assert abs(error).max() < 200  # of 1000
    edge = (truth > 0) & (truth < 1000)
    assert np.sqrt((error[edge] ** 2).mean()) < 30


@pytest.mark.parametrize(
    ("solid", "volume"),
    [
        (ellipsoid((0, 0, 0), (9, 14, 12)), 4 / 3 * np.pi * 9 * 14 * 12),
        (box((1.2, 2.1, 3.3), (5, 6, 7)), 8 * 5 * 6 * 7),
        (shell(ellipsoid((0, 0, 0), (12, 12, 12)), 2), 4 / 3 * np.pi * (14**3 - 10**3)),
        (tube(np.array([(-8.0, 0, 0), (8, 0, 0)]), 3.0)[0], np.pi * 9 * 16 + 4 / 3 * np.pi * 27),
    ],
)
@pytest.mark.parametrize("spacing", SPACINGS)
def test_painted_shares_add_up_to_the_volume(solid, volume, spacing):
    canvas = blank(spacing)
    paint(canvas, [solid], 100.0, 7)
    assert canvas.hu.sum() / 100 * np.prod(spacing) == pytest.approx(volume, rel=0.01)


def test_the_label_is_that_of_the_voxels_centre():
    canvas = blank((1.0, 1.0, 3.0))
    paint(canvas, SOLIDS["egg"], 100.0, 7)
    x, y, z = np.meshgrid(*canvas.axes, indexing="ij")
    inside = ((x - 0.3) / 9) ** 2 + ((y - 0.2) / 14) ** 2 + ((z + 0.4) / 12) ** 2 < 1
    np.testing.assert_array_equal(canvas.labels == 7, inside)


def test_nothing_but_the_wanted_labels_is_painted_on():
    canvas = blank((1.0, 1.0, 1.0))
    canvas.labels[:18] = 3
    paint(canvas, SOLIDS["egg"], 100.0, 7, only=(3,))
    assert not canvas.hu[18:].any() and not canvas.labels[18:].any()
    assert (canvas.labels == 7).any() and canvas.hu[:18].max() == 100


def test_without_a_label_the_labels_stay():
    canvas = blank((1.0, 1.0, 1.0))
    canvas.labels[:] = 3
    paint(canvas, SOLIDS["egg"], 100.0)
    assert (canvas.labels == 3).all() and canvas.hu.max() == 100


def test_solids_are_painted_where_the_bend_puts_them():
    canvas = blank((1.0, 1.0, 1.0), bend=lambda p: (p[0] - p[2] / 4, p[1], p[2]))
    paint(canvas, [ellipsoid((0, 0, 0), (5, 5, 12))], 100.0, 7)
    x, y, z = np.meshgrid(*canvas.axes, indexing="ij")
    inside = ((x - z / 4) / 5) ** 2 + (y / 5) ** 2 + (z / 12) ** 2 < 1
    np.testing.assert_array_equal(canvas.labels == 7, inside)


def test_what_lies_beside_the_image_paints_nothing():
    canvas = blank((1.0, 1.0, 1.0))
    paint(canvas, [ellipsoid((90, 0, 0), (9, 9, 9))], 100.0, 7)
    assert not canvas.hu.any() and not canvas.labels.any()
