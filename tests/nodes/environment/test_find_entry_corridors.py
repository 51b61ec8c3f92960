"""Entries through made-up walls: every needle that is listed is checked against the raw voxels."""

import numpy as np
import pandas
import pytest
from scipy import ndimage
from scipy.spatial.transform import Rotation

from nodes.environment.build_occupancy_grid import build_occupancy_grid
from nodes.environment.find_entry_corridors import find_entry_corridors
from nodes.environment.parameters import (
    BuildOccupancyGridParameters,
    FindEntryCorridorsParameters,
)
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin

SPACING = np.array([1.47, 1.03, 1.91])  # no places that coincide with those of cells
NAMES = ("body", "bone", "effusion", "left_lung")
BODY, BONE, EFFUSION, LUNG = 1, 2, 3, 4
RADIUS, MARGIN = 1.0, 2.0


def parameters(**changed):
    values = {
        "wall_labels": ("body",), "bone_labels": ("bone",),
        "needle_radius_mm": RADIUS, "margin_mm": MARGIN, "thickest_wall_mm": 40.0,
        "tip_depth_mm": 4.0, "largest_tilt_deg": 20.0, "tilt_step_deg": 10.0,
        "skin_spacing_mm": 4.0, "step_mm": 0.2, "candidate_spacing_mm": 9.0,
        "enough_clearance_mm": 50.0,
    }  # fmt: skip
    return FindEntryCorridorsParameters(**{**values, **changed})


def rigid(turn=None, shift=(0.0, 0.0, 0.0)):
    matrix = np.diag([*SPACING, 1.0])
    if turn is not None:
        matrix[:3, :3] = turn @ matrix[:3, :3]
    matrix[:3, 3] = shift
    return matrix


def chest_wall(half_slit, matrix=None, names=NAMES):
    """Air in front (-y), a wall 24.7 mm thick with a plate of bone in it, fluid behind it.

    The plate has one slit along x, in the middle of z; it fills the image else. `half_slit` voxels
    are open on either side of the middle, that is 1.91 mm each.
    """
    voxels = np.zeros((40, 70, 32), np.uint8)
    voxels[:, 15:39] = BODY
    voxels[:, 39:65] = EFFUSION
    plate = np.ones(32, bool)
    plate[16 - half_slit : 16 + half_slit] = False
    voxels[:, 27:33, plate] = BONE
    matrix = rigid() if matrix is None else matrix
    return LabelMap(voxels, matrix, names, Origin("test", simulated=True))


CELL = 1.5


def occupancy(label_map, free=("effusion",), apart=()):
    chosen = BuildOccupancyGridParameters(
        free_labels=free, apart=apart, voxel_size_mm=CELL, neighbourhood="faces",
        inside_patient_mm=(), smallest_part_ml=0.1, volume_tolerance=0.1,
    )  # fmt: skip
    return build_occupancy_grid(label_map, chosen)[0]


def search(label_map, **changed):
    return find_entry_corridors(label_map, occupancy(label_map), parameters(**changed))


def places(row, count=400):
    skin, pleura = (
        np.array([row[f"{end}_{axis}_mm"] for axis in "xyz"]) for end in ("skin", "pleura")
    )
    return skin + np.linspace(0, 1, count)[:, None] * (pleura - skin)


def distance_to(label_map, label, points):
    """Distance of points to the nearest box of a label, mm, by looking at all boxes."""
    along = np.linalg.inv(label_map.patient_from_index)
    index = points @ along[:3, :3].T + along[:3, 3]
    boxes = np.argwhere(label_map.voxels == label)
    near = (abs(boxes - index.mean(axis=0)) * SPACING).max(axis=1) < 60
    gaps = np.maximum(abs(index[:, None] - boxes[near]) - 0.5, 0) * SPACING
    return np.sqrt((gaps**2).sum(axis=2)).min(axis=1)


def labels_at(label_map, points):
    along = np.linalg.inv(label_map.patient_from_index)
    index = np.rint(points @ along[:3, :3].T + along[:3, 3]).astype(int)
    return label_map.voxels[tuple(index.T)]


def tip_places(row, depth, count=400):
    """Places along the tip, from where the needle reaches the free space on."""
    return places(row, 2)[1] + np.linspace(0, depth, count)[:, None] * direction(row)


def check_every_row(label_map, table, chosen):
    assert len(table)
    for row in table.to_dict("records"):
        points = places(row)
        whole = np.concatenate([points, tip_places(row, chosen.tip_depth_mm, 100)])
        bone = distance_to(label_map, BONE, whole)
        assert bone.min() >= RADIUS + MARGIN - 1e-6
        assert row["bone_clearance_mm"] == pytest.approx(bone.min() - RADIUS, abs=0.05)
        assert set(labels_at(label_map, points[2:-4])) == {BODY}
        assert labels_at(label_map, places(row, 3)[2:] + 0.3 * direction(row)) == EFFUSION
        thickness = np.linalg.norm(points[-1] - points[0])
        assert row["wall_thickness_mm"] == pytest.approx(thickness)
        assert thickness <= chosen.thickest_wall_mm + chosen.step_mm
        assert row["tilt_deg"] <= chosen.largest_tilt_deg + 1e-6
        np.testing.assert_allclose(points[0] + thickness * direction(row), points[-1], atol=1e-6)


def direction(row):
    return np.array([row[f"direction_{axis}"] for axis in "xyz"])


def test_needles_pass_the_slit_and_keep_their_distance_from_its_bone():
    label_map = chest_wall(4)
    _, table = search(label_map)
    check_every_row(label_map, table, parameters())
    half, middle = 4 * SPACING[2], 15.5 * SPACING[2]
    for row in table.to_dict("records"):
        within = places(row)
        within = within[(within[:, 1] > 26.5 * SPACING[1]) & (within[:, 1] < 32.5 * SPACING[1])]
        assert (abs(within[:, 2] - middle) <= half - RADIUS - MARGIN + 1e-6).all()
    assert set(table.window) == {1} and set(table.face) == {"front"}
    assert list(table.number) == list(range(1, len(table) + 1))
    assert table.bone_clearance_mm.is_monotonic_decreasing
    # the skin is tried every 4 mm, so one needle is at most 2 mm off the slit's middle
    assert half - RADIUS - 2 <= table.bone_clearance_mm.max() <= half - RADIUS + 1e-6


@pytest.mark.parametrize(("margin_mm", "opens"), [(2.9, False), (2.2, True)])
def test_a_slit_below_needle_and_margins_is_no_opening(margin_mm, opens):
    """A needle of radius 1 finds a slit of 7.64 mm passable with margins of 2.82 at most."""
    label_map = chest_wall(2)
    entry_map, table = search(label_map, margin_mm=margin_mm, skin_spacing_mm=1.0)
    assert bool(len(table)) == opens
    assert entry_map.voxels.any() == opens
    if not opens:
        assert any("no straight needle" in notice for notice in entry_map.origin.notices)


def test_the_map_marks_skin_and_wall_on_the_way_and_nothing_else():
    label_map = chest_wall(4)
    entry_map, table = search(label_map)
    assert entry_map.names == ("entry", "corridor")
    np.testing.assert_array_equal(entry_map.patient_from_index, label_map.patient_from_index)
    assert (label_map.voxels[entry_map.voxels > 0] == BODY).all()
    skin = np.argwhere(entry_map.mask("entry"))
    assert len(skin) and set(skin[:, 1]) == {15}
    # a corner of a voxel that a needle cuts between two places that are looked at may be missed
    near = LabelMap(
        ndimage.grey_dilation(entry_map.voxels, 3), rigid(), entry_map.names, entry_map.origin
    )
    for row in table.to_dict("records"):
        assert (labels_at(entry_map, places(row)[2:-4]) > 0).mean() > 0.95
        assert (labels_at(near, places(row)[2:-4]) > 0).all()
    assert any("heart" in notice for notice in entry_map.origin.notices)
    assert entry_map.origin.simulated


@pytest.mark.parametrize("seed", [0, 1])
def test_a_turned_patient_has_the_same_entries(seed):
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    shift = np.array([30.0, -200.0, 70.0])
    _, straight = search(chest_wall(4))
    label_map = chest_wall(4, rigid(turn, shift))
    _, turned = search(label_map)
    check_every_row(label_map, turned, parameters())
    assert len(straight) == len(turned)
    for end in ("skin", "pleura"):
        columns = [f"{end}_{axis}_mm" for axis in "xyz"]
        expected = straight[columns].to_numpy() @ turn.T + shift
        np.testing.assert_allclose(turned[columns].to_numpy(), expected, atol=1e-6)
    np.testing.assert_allclose(turned.bone_clearance_mm, straight.bone_clearance_mm, atol=1e-9)


def test_entries_keep_apart_on_the_skin():
    _, table = search(chest_wall(4), candidate_spacing_mm=12.0)
    skin = table[["skin_x_mm", "skin_y_mm", "skin_z_mm"]].to_numpy()
    apart = np.linalg.norm(skin[:, None] - skin, axis=2)
    assert apart[~np.eye(len(skin), dtype=bool)].min() > 12.0


def test_two_slits_are_two_windows():
    label_map = chest_wall(0)
    voxels = label_map.voxels.copy()
    for first in (5, 20):
        voxels[:, 27:33, first : first + 7] = BODY
    _, table = search(LabelMap(voxels, rigid(), NAMES, label_map.origin))
    assert set(table.window) == {1, 2}
    for _, rows in table.groupby("window"):
        assert np.ptp(rows.pleura_z_mm) < 20


def test_a_lung_before_the_fluid_is_not_passed():
    label_map = chest_wall(4)
    voxels = label_map.voxels.copy()
    voxels[:20, 39:44] = LUNG
    _, table = search(LabelMap(voxels, rigid(), NAMES, label_map.origin))
    assert len(table)
    lung_ends = 19.5 * SPACING[0]
    assert (table.pleura_x_mm - lung_ends).min() >= RADIUS + MARGIN - 1e-6


def pitted(seed=0):
    """A wall with a knob of bone in the fluid behind it, and blocks of wall like diaphragm."""
    label_map = chest_wall(6)
    voxels = label_map.voxels.copy()
    voxels[10:14, 42:46, 14:17] = BONE
    random = np.random.default_rng(seed)
    for i, k in zip(random.integers(0, 38, 12), random.integers(0, 30, 12), strict=True):
        voxels[i : i + 3, 44:48, k : k + 2] = BODY
    return LabelMap(voxels, label_map.patient_from_index, NAMES, label_map.origin)


def test_bone_behind_the_wall_counts_in_the_clearance_of_the_tip():
    label_map = pitted()
    _, table = search(label_map, candidate_spacing_mm=3.0)
    at_tip = 0
    for row in table.to_dict("records")[::3]:
        wall = distance_to(label_map, BONE, places(row)).min()
        tip = distance_to(label_map, BONE, tip_places(row, 4.0)).min()
        assert row["bone_clearance_mm"] == pytest.approx(min(wall, tip) - RADIUS, abs=0.02)
        at_tip += tip < wall - 0.1
    assert at_tip  # else this shows nothing


@pytest.mark.parametrize("depth", [1.0, 4.0, 7.0])
@pytest.mark.parametrize("seed", [0, 1])
def test_tips_end_free_and_leave_the_boundary_within_a_cells_diagonal(seed, depth):
    label_map = pitted(seed)
    grid = occupancy(label_map)
    chosen = parameters(candidate_spacing_mm=3.0, tip_depth_mm=depth)
    _, table = find_entry_corridors(label_map, grid, chosen)
    free = grid.names.index("free") + 1
    assert len(table)
    for row in table.to_dict("records"):
        behind = tip_places(row, depth, 1500)[int(1500 * CELL * 3**0.5 / depth) + 1 :]
        assert (labels_at(grid, behind) == free).all()
        assert labels_at(grid, tip_places(row, depth)[-1:]) == free
        assert row["part"] == "free"


def two_lungs(turned=False):
    """The wall with its slit before two spaces that touch in the middle of x."""
    label_map = chest_wall(4)
    voxels = label_map.voxels.copy()
    voxels[voxels == EFFUSION] = 3
    voxels[22:, 39:65] = 4
    names = ("body", "bone", "left_lung", "right_lung")
    voxels = voxels[::-1] if turned else voxels
    return LabelMap(np.ascontiguousarray(voxels), rigid(), names, label_map.origin)


@pytest.mark.parametrize("turned", [False, True])
def test_entries_lead_into_each_of_two_lungs_and_keep_away_from_the_other(turned):
    label_map = two_lungs(turned)
    lungs = ("left_lung", "right_lung")
    grid = occupancy(label_map, lungs, (lungs,))
    entry_map, table = find_entry_corridors(label_map, grid, parameters())
    assert set(table.part) == {"free", "part_2"} and set(table.window) == {1, 2}
    assert any("into 2 separate parts" in notice for notice in entry_map.origin.notices)
    for row in table.to_dict("records"):
        own, other = (3, 4) if row["part"] == "free" else (4, 3)
        assert (labels_at(label_map, tip_places(row, 4.0)[20:]) == own).all()
        assert distance_to(label_map, other, places(row)).min() >= RADIUS + MARGIN - 1e-6
        assert (labels_at(entry_map, places(row)[2:-4]) > 0).mean() > 0.95


def test_limits_on_wall_and_tip_are_kept():
    label_map = chest_wall(4)
    assert not len(search(label_map, thickest_wall_mm=23.0)[1])
    assert not len(search(label_map, tip_depth_mm=40.0)[1])
    assert len(search(label_map, thickest_wall_mm=25.0, tip_depth_mm=20.0)[1])


def test_without_bone_nothing_is_called_safe_and_the_table_keeps_its_columns():
    voxels = np.where(chest_wall(4).voxels == BONE, BODY, chest_wall(4).voxels)
    with_name = LabelMap(voxels.astype(np.uint8), rigid(), NAMES, Origin("x"))
    voxels = np.where(voxels == EFFUSION, 2, voxels).astype(np.uint8)
    without = LabelMap(voxels, rigid(), ("body", "effusion"), Origin("x"))
    _, full = search(chest_wall(4))
    for label_map in (with_name, without):
        entry_map, table = search(label_map)
        assert isinstance(table, pandas.DataFrame) and not len(table)
        assert not entry_map.voxels.any()
        assert any("no bone is labelled" in notice for notice in entry_map.origin.notices)
        assert list(table.columns) == list(full.columns)
        assert list(table.dtypes) == list(full.dtypes)


def test_unknown_labels_and_grids_of_other_images_are_refused():
    label_map = chest_wall(4)
    with pytest.raises(BadInput, match="effusion"):
        search(label_map, wall_labels=("muscle",))
    empty = LabelMap(np.zeros((40, 70, 32), np.uint8), rigid(), NAMES, Origin("x"))
    with pytest.raises(BadInput, match="nothing is labelled"):
        find_entry_corridors(empty, occupancy(label_map), parameters())
    turned = rigid(Rotation.from_euler("z", 10, degrees=True).as_matrix())
    with pytest.raises(BadInput, match="axes"):
        find_entry_corridors(chest_wall(4, turned), occupancy(label_map), parameters())


def test_the_same_labels_give_the_same_entries():
    one, same = (search(chest_wall(4)) for _ in range(2))
    np.testing.assert_array_equal(one[0].voxels, same[0].voxels)
    pandas.testing.assert_frame_equal(one[1], same[1])
