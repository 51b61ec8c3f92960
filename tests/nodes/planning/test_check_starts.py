"""Set-ups that a person hands in: taken if they work, else refused with what would work."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.mechanics.materials import NITINOL
from nodes.mechanics.parameters import FollowCrispEdgesParameters
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, PointLoad, Snare
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.check_entries import check_entries
from nodes.planning.check_starts import check_kind, check_start
from nodes.planning.parameters import ClearanceParameters
from nodes.planning.setup_judging import Scene, judge_starts
from nodes.planning.setup_nearest import Search
from tests.nodes.planning.made_cavity import chest, occupancy, place

CHEST = chest()
GRID, DISTANCE = occupancy(CHEST)
CLEARANCES = ClearanceParameters(
    margin_mm=0.5, sheath_mm=5.0, outside_mm=15.0, grasp_mm=5.0, sheath_avoids=("bone",),
    piece_mm=8.0, coarsest_cell=9.0,
)  # fmt: skip
SOLVING = FollowCrispEdgesParameters(
    tolerance_mm=1e-6, integration_error_mm=1e-7, largest_bend_rad=0.5, iterations=12,
    steps_between_checks=10, refinements=3,
)  # fmt: skip
SEARCH = Search(32.0, 60, 0)


def frames():
    """Tool along +y, snare along +x, rolled for a rigid joint; columns are the axes."""
    across = np.cross([0.0, 1, 0], [1.0, 0, 0])
    tool = np.stack([across, [-1.0, 0, 0], [0.0, 1, 0]], axis=-1)
    return np.stack([tool, np.stack([across, [0.0, 1, 0], [1.0, 0, 0]], axis=-1)])


def placed(tool=(29, 11.5, 30), snare=(11.5, 26, 30), lengths=None, **changed):
    """A tool from the front and a snare from the side that meet at a right angle."""
    entries = np.array([place(*tool), place(*snare)])
    needle = Needle(NITINOL, 0.84, 1.02, np.zeros(3))
    setup = CrispSetup((needle, needle), entries, (Snare(1, 10.0, "tip", "rigid"),), 90.0)
    apart = entries[1] - entries[0]
    lengths = (apart[1] + 10, -apart[0]) if lengths is None else lengths
    values = {
        "name": "mine", "setup": setup,
        "start": CrispConfiguration(frames(), np.array(lengths, float)),
        "axes": frames()[..., 2], "largest_tilts_rad": np.full(2, 1.0),
        "shortest_mm": np.full(2, 8.0), "longest_mm": np.full(2, 90.0),
    }  # fmt: skip
    return PlacedSetup(**{**values, **changed})


@pytest.fixture(scope="module")
def scene():
    return Scene(make_cavity(GRID, DISTANCE), make_wall(CHEST, ("bone",)), CLEARANCES, SOLVING)


def check_all(one, scene, label_map=CHEST, grid=GRID):
    check_kind(one)
    check_entries(one, label_map, grid, ("bone",), CLEARANCES.sheath_mm)
    check_start(one, scene, SEARCH)


def test_a_set_up_that_works_is_let_pass(scene):
    check_all(placed(), scene)


@pytest.mark.parametrize(
    ("tool", "said"),
    [
        ((29, -8, 30), "beyond the image"),
        ((20, 7, 30), "lies in bone"),
        ((29, 1, 30), r"lies in no label, 21\.\d mm from the free space"),
        ((29, 4, 30), r"lies in body, 15\.\d mm from the free space"),
        ((29, 20, 30), r"inside of the free space, 1\d\.\d mm from its wall"),
    ],
)
def test_entry_points_off_the_wall_are_refused(tool, said):
    with pytest.raises(BadInput, match=said) as error:
        check_entries(placed(tool=tool), CHEST, GRID, ("bone",), CLEARANCES.sheath_mm)
    assert "entry_points_patient_mm[0]" in error.value.value and error.value.cure


def test_an_entry_into_another_part_of_the_free_space_names_both_and_their_volumes():
    label_map = chest(parts=2)
    grid, _ = occupancy(label_map)
    large, small = 24 * 30 * 40 * 8 / 1000, 8 * 30 * 40 * 8 / 1000
    with pytest.raises(BadInput, match="leads into part_2") as error:
        check_entries(placed(tool=(44, 11.5, 30)), label_map, grid, ("bone",), 5.0)
    said = error.value.value.replace(",", " ").split()
    volumes = [float(n) for n, unit in pairwise(said) if unit == "ml"]
    assert volumes == pytest.approx([small, large], rel=0.01)
    check_entries(placed(tool=(20, 11.5, 30)), label_map, grid, ("bone",), 5.0)


def test_starts_beyond_their_limits_are_refused():
    with pytest.raises(BadInput, match=r"needle 0 starts 20\.0 degrees from its axis"):
        tilted = np.array([[0, np.cos(np.radians(20)), np.sin(np.radians(20))], [1, 0, 0]])
        check_kind(placed(axes=tilted, largest_tilts_rad=np.full(2, 0.3)))
    with pytest.raises(BadInput, match="needle 1 starts 35 mm inside"):
        check_kind(placed(longest_mm=np.array([90.0, 30.0])))
    with pytest.raises(BadInput, match="grasps the tool 10 mm from its tip, and 9 mm"):
        check_kind(placed(lengths=(9.0, 35.0)))


def test_curved_needles_and_loads_are_refused():
    one = placed()
    curved = Needle(NITINOL, 0.84, 1.02, np.array([0.001, 0, 0]))
    with pytest.raises(BadInput, match="needle 1 is curved"):
        needles = (one.setup.needles[0], curved)
        check_kind(replace(one, setup=replace(one.setup, needles=needles)))
    load = PointLoad(5.0, np.array([0, 0, 1.0]), np.zeros(3))
    with pytest.raises(BadInput, match="1 loads"):
        check_kind(replace(one, start=replace(one.start, loads=(load,))))


def pasted(one, cure):
    """The set-up with the start that an error offers, read as a person would paste it."""
    text = yaml.safe_load(cure.split("\n", 1)[1])
    quaternions = [turn["quaternion"] for turn in text["orientations"]]
    turns = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    return replace(one, start=CrispConfiguration(turns, np.array(text["lengths_mm"])))


def distance_between(one, other):
    apart = other.patient_from_entry @ one.patient_from_entry.swapaxes(-1, -2)
    cosine = (np.trace(apart, axis1=-2, axis2=-1) - 1) / 2
    turns = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return np.sqrt((turns**2).sum() + ((other.lengths_mm - one.lengths_mm) ** 2).sum())


def test_a_start_that_touches_is_refused_with_a_start_near_by_that_works(scene):
    one = placed(snare=(11.5, 37.5, 30))  # its tool's tip is in the wall behind
    with pytest.raises(BadInput, match="touches: a needle touches anatomy") as error:
        check_start(one, scene, SEARCH)
    other = pasted(one, error.value.cure)
    check_all(other, scene)
    told = float(error.value.cure.split(" degrees and mm")[0].split()[-1])
    assert told == pytest.approx(distance_between(one.start, other.start), abs=0.1)
    assert told < 10
    with pytest.raises(BadInput) as again:
        check_start(one, scene, SEARCH)
    assert again.value.cure == error.value.cure


def test_a_start_without_solution_is_refused_with_a_start_that_works(scene):
    one = placed(lengths=(39.0, 12.0))
    with pytest.raises(BadInput, match="a snare is too short") as error:
        check_start(one, scene, SEARCH)
    check_all(pasted(one, error.value.cure), scene)


def test_where_nothing_near_by_works_the_error_says_how_far_was_looked(scene):
    one = placed(longest_mm=np.array([41.0, 12.0]), lengths=(39.0, 12.0))
    with pytest.raises(BadInput, match=r"no start that works was found within 32"):
        check_start(one, scene, SEARCH)


def test_starts_are_judged_as_they_are_one_by_one(scene):
    one = placed()
    lengths = one.start.lengths_mm + np.array([[0, 0], [-3, 0], [0, -23.5], [45, 25]])
    turns = np.repeat(frames()[None], 4, axis=0)
    together = judge_starts(one.setup, turns, lengths, scene)
    alone = [judge_starts(one.setup, turns[:1], row[None], scene)[0] for row in lengths]
    assert together.tolist() == alone
    assert together[0] == 0 and together[2] > 0
