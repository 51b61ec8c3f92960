"""The body without its table, however heavily it lies there, and nothing cut off without one."""

import numpy as np
import pytest
import yaml

from nodes.imaging.ct_body import find_body, table_notices
from nodes.imaging.ct_scan import CtScan
from nodes.imaging.make_thorax_phantom import make_thorax_phantom
from nodes.imaging.parameters import MakeThoraxPhantomParameters
from tests.nodes.imaging.made_chest import DEFAULTS, dice, parameters

STEP, AIR, MATTRESS = 3.0, -1000, -150
BACK = 90.0  # of the trunk below, mm
UNOPENED = parameters(table_opening_mm=0.0)  # so that flanks keep their last voxel


def trunk():
    """An oval trunk with a spine, narrower above, on 380 x 240 x 90 mm."""
    x, y, z = (np.arange(-half + STEP / 2, half, STEP) for half in (190, 120, 45))
    x, y, z = x[:, None, None], y[None, :, None], z[None, None, :]
    inside = (x / (140 - 0.3 * z)) ** 2 + (y / BACK) ** 2 < 1
    hu = np.where(inside, 40, AIR)
    hu[np.broadcast_to(np.hypot(x, y - 60) < 15, hu.shape)] = 400
    return hu.astype(np.int16), inside, (x, y, z)


def scan_of(hu):
    return CtScan(hu, np.diag([STEP, STEP, STEP, 1.0]), np.zeros(hu.shape, bool))


def laid_on(hu, table):
    return np.where(np.broadcast_to(table, hu.shape) & (hu == AIR), MATTRESS, hu).astype(np.int16)


@pytest.mark.parametrize("sunk_mm", [0, 3, 6])
@pytest.mark.parametrize("prone", [False, True])
@pytest.mark.parametrize("half_width", [165, 1000])
def test_a_table_that_the_back_lies_on_is_cut_off_along_its_top(sunk_mm, prone, half_width):
    hu, inside, (x, y, _) = trunk()
    top = BACK - sunk_mm
    table = (y > top) & (y < top + 18) & (abs(x) < half_width)
    on_table = laid_on(hu, table)
    if prone:
        on_table, inside = on_table[:, ::-1], inside[:, ::-1]
    scan = scan_of(np.ascontiguousarray(on_table))
    body = find_body(scan, UNOPENED)
    below = (y > top)[:, ::-1] if prone else y > top
    np.testing.assert_array_equal(body, inside & ~below)
    assert not table_notices(scan, body, UNOPENED)


def test_a_sloping_table_is_cut_off_along_its_slope():
    hu, inside, (x, y, _) = trunk()
    top = BACK + 4 + 0.1 * x
    body = find_body(scan_of(laid_on(hu, (y > top) & (y < top + 18))), parameters())
    assert dice(body, inside) > 0.99


def test_a_hollow_table_is_not_cut_but_told():
    hu, _, (x, y, _) = trunk()
    top = BACK - (x / 190) ** 2 * 60
    scan = scan_of(laid_on(hu, (y > top) & (y < top + 18)))
    body = find_body(scan, parameters())
    assert body[1, :, 10].any()
    assert any("table" in notice for notice in table_notices(scan, body, parameters()))


def test_a_flat_back_without_a_table_keeps_its_shape():
    hu, inside, (_, y, _) = trunk()
    flat = inside & (y < BACK - 15)
    scan = scan_of(np.where(flat, hu, AIR).astype(np.int16))
    body = find_body(scan, UNOPENED)
    np.testing.assert_array_equal(body, flat)
    assert not table_notices(scan, body, UNOPENED)


def test_what_holds_bone_is_not_cut_off_as_a_table():
    hu, _, (x, y, z) = trunk()
    table = (y > BACK - 3) & (y < BACK + 15)
    on_table = laid_on(hu, table)
    on_table[np.broadcast_to(table & (abs(x) < 30) & (abs(z) < 30), hu.shape)] = 600
    body = find_body(scan_of(on_table), parameters())
    assert body[np.broadcast_to(table, hu.shape)].all()


def test_a_block_that_fills_the_image_is_no_table():
    body = find_body(scan_of(np.full((60, 50, 20), 40, np.int16)), parameters())
    assert body.all()


@pytest.mark.parametrize("seed", [2, 9])
def test_a_phantom_of_any_build_lies_on_its_table_and_is_parted_from_it(seed):
    values = yaml.safe_load((DEFAULTS / "make_thorax_phantom.yml").read_text())
    values |= {"variation": 1.0, "seed": seed}
    values |= {"pixel_spacing_mm": 2.5, "slice_thickness_mm": 8.0}
    files, truth = make_thorax_phantom(MakeThoraxPhantomParameters(**values))
    stack = sorted(files.slices, key=lambda one: one.patient_from_pixel[2, 3])
    hu = np.stack([one.pixels.T for one in stack], axis=2)
    scan = CtScan(hu, truth.patient_from_index, np.zeros(hu.shape, bool))
    assert dice(find_body(scan, parameters()), truth.voxels > 0) > 0.99
