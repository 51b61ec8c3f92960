"""Labels laid over one another: who lies on top, what is told, what is refused."""

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.geometry.origin import Origin
from nodes.geometry.regridding import Grid
from nodes.imaging.lay_labels import join_origins, lay_layers, name_layers
from tests.nodes.imaging.handed_in import block, file_labels, files, mask_file, steps

SHAPE = (10, 10, 10)
GRID = Grid(np.eye(4), SHAPE)
LUNG = block(SHAPE, (1, 9), (1, 9), (1, 9))
AIRWAY = block(SHAPE, (3, 5), (3, 5), (3, 10))


def laid(label_files, order=(), names=None, grid=GRID):
    layers = name_layers(label_files, names or {}, 1)
    voxels, notices = lay_layers(layers, order, grid, 0.01)
    return {name: voxels == n for n, name in enumerate(layers, start=1)}, notices


def test_the_smaller_label_lies_on_top_and_what_it_covers_is_told():
    masks, notices = laid(files(mask_file("airway", AIRWAY), mask_file("lung", LUNG)))
    np.testing.assert_array_equal(masks["airway"], AIRWAY)
    np.testing.assert_array_equal(masks["lung"], LUNG & ~AIRWAY)
    assert notices == ("lung: 0.024 ml lie under airway and count as that",)


def test_order_puts_a_label_on_top_of_smaller_ones():
    handed = files(mask_file("airway", AIRWAY), mask_file("lung", LUNG))
    masks, _ = laid(handed, ["lung"])
    np.testing.assert_array_equal(masks["lung"], LUNG)
    np.testing.assert_array_equal(masks["airway"], AIRWAY & ~LUNG)


def test_the_last_in_order_is_the_topmost():
    a, b = block(SHAPE, (0, 5), (0, 5), (0, 5)), block(SHAPE, (3, 8), (0, 5), (0, 5))
    handed = files(mask_file("a", a), mask_file("b", b))
    for order in (["a", "b"], ["b", "a"]):
        masks, _ = laid(handed, order)
        np.testing.assert_array_equal(masks[order[-1]], {"a": a, "b": b}[order[-1]])


def test_labels_of_one_name_are_joined_and_that_is_told():
    left, right = block(SHAPE, (0, 4), (0, 9), (0, 9)), block(SHAPE, (3, 9), (0, 9), (0, 9))
    handed = files(mask_file("left_rib", left), mask_file("right_rib", right))
    names = {"left_rib": "bone", "right_rib": "bone"}
    masks, notices = laid(handed, names=names)
    np.testing.assert_array_equal(masks["bone"], left | right)
    assert notices == ()
    origin = join_origins(handed, name_layers(handed, names, 1))
    assert origin.notices == ("bone: joined from left_rib, right_rib",)


def test_a_label_called_nothing_is_left_out_and_that_is_told():
    handed = files(mask_file("airway", AIRWAY), mask_file("lung", LUNG), skipped=3)
    masks, _ = laid(handed, names={"airway": ""})
    assert list(masks) == ["lung"]
    origin = join_origins(handed, name_layers(handed, {"airway": ""}, 1))
    assert origin.notices == (
        "3 files that are no label maps were left out",
        "airway: left out",
    )


def test_two_labels_of_one_file_are_taken_apart():
    both = file_labels(LUNG + 2 * (AIRWAY & ~LUNG), ("lung", "tip"))
    masks, _ = laid(files(both))
    np.testing.assert_array_equal(masks["lung"], LUNG)
    np.testing.assert_array_equal(masks["tip"], AIRWAY & ~LUNG)


def test_simulated_labels_make_the_result_simulated():
    simulated = file_labels(AIRWAY * 1, ("airway",), origin=Origin("phantom", True, ("noise",)))
    handed = files(simulated, mask_file("lung", LUNG))
    origin = join_origins(handed, name_layers(handed, {}, 1))
    assert origin == Origin("phantom, label maps handed in", True, ("noise",))


def test_the_change_of_volume_by_another_grid_is_told_in_percent():
    """8 x 8 x 8 mm on voxels of 3 mm: 3 x 3 x 3 of them are at least half in it."""
    cube = mask_file("cube", LUNG, steps(1, 1, 1, start=(0.5, 0.5, 0.5)))
    masks, notices = laid(files(cube), grid=Grid(steps(3, 3, 3, start=(2, 2, 2)), (4, 4, 4)))
    assert masks["cube"].sum() == 27
    assert notices == (
        "cube: brought from another grid (1 x 1 x 1 mm); 0.512 ml became 0.729 ml (+42.4 %)",
    )


def test_a_thin_vessel_that_breaks_is_told():
    """A line of single voxels, turned and a third of a voxel up, has less than half of many."""
    vessel = block((40, 5, 5), (2, 38), (2, 3), (2, 3))
    turn = np.deg2rad(20)
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    grid = Grid(steps(1, 1, 1, start=(-2, 0, 0.33)), (45, 20, 5))
    masks, notices = laid(files(mask_file("vessel", vessel, matrix)), grid=grid)
    assert 0 < masks["vessel"].sum() < 36
    assert "0.036 ml became 0.0" in notices[0] and "parts instead of 1" in notices[0]
    assert f"({100 * (masks['vessel'].sum() / 36 - 1):+.1f} %)" in notices[0]


def test_a_thin_vessel_that_vanishes_is_refused_with_its_volume():
    vessel = block((40, 5, 5), (2, 38), (2, 3), (2, 3))
    handed = files(mask_file("vessel", vessel, steps(1, 1, 1, start=(0, 0.5, 0.5))))
    with pytest.raises(
        BadInput, match=r"label vessel has 0.036 ml in its file and fills no voxel of 1 x"
    ):
        laid(handed, grid=Grid(np.eye(4), (40, 6, 6)))


def test_a_label_that_loses_all_its_voxels_to_others_is_refused():
    handed = files(mask_file("airway", AIRWAY & LUNG), mask_file("lung", LUNG))
    with pytest.raises(BadInput, match="label airway lies under lung in all its voxels"):
        laid(handed, order=["lung"])


@pytest.mark.parametrize(
    ("order", "told"),
    [
        (["airways"], "order: airways\n.*airway, lung"),
        (["lung", "lung"], "each name stands there once"),
    ],
)
def test_a_wrong_order_is_refused(order, told):
    handed = files(mask_file("airway", AIRWAY), mask_file("lung", LUNG))
    with pytest.raises(BadInput, match=told):
        laid(handed, order=order)


def test_a_name_that_no_file_has_is_refused_with_those_that_are_there():
    with pytest.raises(BadInput, match=r"names: bronchi\n.*the labels are airway, lung"):
        name_layers(
            files(mask_file("airway", AIRWAY), mask_file("lung", LUNG)), {"bronchi": "x"}, 1
        )


def test_a_tiny_label_is_refused_with_its_count():
    with pytest.raises(BadInput, match=r"label dot has 7 voxels\n.*at least 8"):
        name_layers(files(mask_file("dot", block(SHAPE, (0, 7), (0, 1), (0, 1)))), {}, 8)


def test_more_than_255_labels_are_refused_unless_they_are_joined():
    maps = [mask_file(f"m{n}", block((1, 1, 300), (0, 1), (0, 1), (n, n + 1))) for n in range(256)]
    with pytest.raises(BadInput, match="256 labels"):
        name_layers(files(*maps), {}, 1)
    assert len(name_layers(files(*maps), {"m0": "m", "m1": "m"}, 1)) == 255
