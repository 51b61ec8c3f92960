"""Which needles are listed, in which order, and what is told of them."""

import numpy as np
import pytest

from nodes.environment.entry_table import Needles, list_entries
from nodes.environment.needle_space import WALL, NeedleSpace
from nodes.environment.parameters import FindEntryCorridorsParameters


def parameters(apart=5.0, enough=50.0, tip=1.0):
    return FindEntryCorridorsParameters(
        wall_labels=("b",), bone_labels=("c",), needle_radius_mm=1.0,
        margin_mm=0.0, thickest_wall_mm=20.0, tip_depth_mm=tip, largest_tilt_deg=10.0,
        tilt_step_deg=10.0, skin_spacing_mm=2.0, step_mm=0.2, candidate_spacing_mm=apart,
        enough_clearance_mm=enough,
    )  # fmt: skip


def space():
    """A block of wall with one voxel of bone at (30, 10, 10) mm; its axes are turned."""
    bone = np.zeros((60, 20, 20), bool)
    bone[30, 10, 10] = True
    patient_from_grid = np.array([[0, -1.0, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]])
    kinds = np.full(bone.shape, WALL, np.uint8)
    return NeedleSpace(
        kinds=kinds,
        bone=bone,
        distance=np.zeros(bone.shape, np.float32),
        spacing=np.ones(3),
        box=(slice(0), slice(0), slice(0)),
        middle=np.array([-6.0, 0, 0]),
        patient_from_grid=patient_from_grid,
        part="free",
        cells=np.ones((1, 1, 1), bool),
        cell_from_grid=np.eye(4),
    )


def needles(x, nearest):
    """Needles along y, side by side along x."""
    x = np.asarray(x, float)
    skin = np.stack([x, np.full(len(x), 1.0), np.full(len(x), 10.0)], axis=1)
    along = np.tile([0.0, 1.0, 0.0], (len(x), 1))
    return Needles(skin, skin + 12 * along, along, along, np.asarray(nearest, float),
                   np.ones(len(x), int))  # fmt: skip


def test_the_best_of_their_surroundings_are_listed_the_most_room_first():
    table = list_entries([(needles([20, 22, 24, 40], [9, 8, 5, 3]), space())], parameters())
    # 22 and 24 are within 5 mm of 20; bone begins at x = 30 +- 0.5, and the needle's radius is 1
    assert list(table.bone_clearance_mm) == pytest.approx([8.5, 8.5])
    assert list(table.number) == [1, 2]
    assert list(table.skin_y_mm) == pytest.approx([26, 46])  # x of the grid is y of the patient
    assert list(table.wall_thickness_mm) == pytest.approx([12, 12])


def test_places_directions_and_sides_are_the_patients():
    table = list_entries([(needles([20], [9]), space())], parameters())
    (row,) = table.to_dict("records")
    assert [row[f"skin_{a}_mm"] for a in "xyz"] == pytest.approx([5 - 1, 6 + 20, 7 + 10])
    assert [row[f"direction_{a}"] for a in "xyz"] == pytest.approx([-1, 0, 0])
    assert (row["side"], row["face"]) == ("left", "side")
    assert row["tilt_deg"] == pytest.approx(0)


def test_bone_out_of_reach_leaves_the_reach_as_clearance():
    table = list_entries([(needles([1], [9]), space())], parameters())
    assert table.bone_clearance_mm[0] == pytest.approx(20 - 1)


def test_where_room_is_enough_the_thinner_wall_comes_first():
    side_by_side = needles([5, 20, 48], [24, 9, 17])
    longer = side_by_side.pleura + np.array([[0, 3, 0], [0, 0, 0], [0, 1, 0]])
    side_by_side = side_by_side._replace(pleura=longer)
    by_wall = list_entries([(side_by_side, space())], parameters(enough=5.0))
    assert list(by_wall.wall_thickness_mm) == pytest.approx([12, 13, 15])
    by_room = list_entries([(side_by_side, space())], parameters(enough=50.0))
    assert by_room.bone_clearance_mm.is_monotonic_decreasing
    assert by_room.wall_thickness_mm.iloc[-1] == pytest.approx(12)


@pytest.mark.parametrize(("depth", "away"), [(0.5, 4.0), (3.0, 1.5), (6.0, 0.0)])
def test_bone_behind_the_pleura_counts_as_far_as_the_tip_goes(depth, away):
    """The tip points at the voxel of bone, whose box begins 4.5 mm behind the pleura."""
    one = needles([30], [9])
    skin = np.array([[30.0, -7.0, 10.0]])
    one = one._replace(skin=skin, pleura=skin + 12 * one.direction)
    table = list_entries([(one, space())], parameters(tip=depth))
    assert table.bone_clearance_mm[0] == pytest.approx(away - 1, abs=1e-6)


def test_each_part_lists_its_own_entries_and_all_are_numbered_together():
    near, far = needles([20], [9]), needles([18], [11])
    other = space()._replace(part="part_2")
    table = list_entries([(near, space()), (far, other)], parameters())
    assert list(table.part) == ["part_2", "free"]  # also where they are within 5 mm on the skin
    assert list(table.number) == [1, 2]
    assert table.bone_clearance_mm.is_monotonic_decreasing
