"""Setups and configurations as arrays."""

import numpy as np
import pytest

from nodes.kernels.crisp_general_problem import pack
from nodes.mechanics.crisp_arrays import to_grasps, to_loads, to_rods
from nodes.mechanics.robots import PointLoad, Snare
from nodes.mechanics.solve_crisp import to_crisp
from tests.nodes.mechanics.crisp_reference import CASES, case_robot
from tests.nodes.mechanics.made_robots import crisp, needle, poses


@pytest.mark.parametrize("name", ["rigid1_0", "precurved1_1", "relaxed2_1"])
def test_stiffness_is_the_published_one(name):
    rods = to_rods(case_robot(CASES[name])[0])
    tubes = CASES[name]["tubes"]
    assert rods.bending == pytest.approx([tube["EI"] for tube in tubes], rel=1e-11)
    assert rods.torsion == pytest.approx([tube["GJ"] for tube in tubes], rel=1e-11)
    assert rods.precurvature.tolist() == [tube["uhat"] for tube in tubes]


def test_grasps_are_sorted_along_the_tool_from_where_they_are_measured():
    snares = (Snare(1, 20.0, "tip"), Snare(2, 50.0, "entry", "rigid"), Snare(3, 150.0, "entry"))
    entries = np.array([[0.0, 0, 0], [100, 0, 80], [0, 100, 120], [-100, 0, 80]])
    setup = crisp(needles=(needle(),) * 4, entry_points_patient_mm=entries, snares=snares)
    grasps = to_grasps(setup, 170.0)
    assert grasps.snare.tolist() == [2, 1, 3]  # 1 and 3 at one place keep their order
    assert grasps.arc.tolist() == [50, 150, 150]
    assert grasps.rigid.tolist() == [True, False, False]
    assert to_grasps(setup, 200.0).snare.tolist() == [2, 3, 1]


def test_loads_are_sorted_and_none_are_none():
    none = to_loads(poses())
    assert none.arc.shape == (0,) and none.force.shape == none.moment.shape == (0, 3)
    far, near = (PointLoad(arc, np.full(3, arc), -np.full(3, arc)) for arc in (90.0, 30.0))
    loads = to_loads(poses(loads=(far, near)))
    assert loads.arc.tolist() == [30, 90]
    assert loads.force[:, 0].tolist() == [30, 90] and loads.moment[:, 2].tolist() == [-30, -90]


def test_packed_bases_are_states_of_rods():
    setup, configuration = case_robot(CASES["mixed2_load_1"])
    packed = pack(to_crisp(setup, configuration))
    for row, entry, frame in zip(
        packed.bases,
        setup.entry_points_patient_mm,
        configuration.patient_from_entry,
        strict=True,
    ):
        assert row[:3].tolist() == entry.tolist()
        assert row[9:12].tolist() == frame[:, 2].tolist()  # the tangent
        assert row[3:6].tolist() == frame[:, 0].tolist()
    assert packed.joints[:, 1].tolist() == [1, 2]
    assert packed.loads[0, 4:].tolist() == list(configuration.loads[0].force_n)
