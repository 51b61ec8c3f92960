"""Shapes of concentric tube robots: rods, samples, figures, notices."""

import numpy as np
import pytest

from nodes.geometry.origin import Origin
from nodes.mechanics.parameters import ShapeConcentricTubesParameters
from nodes.mechanics.robots import ConcentricTubeRobot
from nodes.mechanics.shape_concentric_tubes import shape_concentric_tubes
from tests.nodes.mechanics.concentric_reference import (
    joint_values,
    reference_cases,
    reference_joints,
    reference_robot,
    tubes_of,
)

PARAMETERS = ShapeConcentricTubesParameters(sample_spacing_mm=2.0)
CASE = reference_cases()[12]


def shape_of(robot, joints):
    return shape_concentric_tubes(robot, joints, PARAMETERS)


def figure(shape, name):
    (found,) = [one for one in shape.figures if one.name == name]
    return found


def test_each_tube_shows_where_it_is_the_outermost():
    shape = shape_of(reference_robot(CASE), reference_joints(CASE))
    tips = np.array(CASE["beta"]) + [tube["Ls"] + tube["Lc"] for tube in CASE["tubes"]]
    assert [rod.name for rod in shape.rods] == ["tube 1", "tube 2", "tube 3"]
    for rod, low, high, tube in zip(shape.rods, [*tips[1:], 0.0], tips, CASE["tubes"], strict=True):
        assert rod.arc_lengths_mm[[0, -1]] == pytest.approx([low, high])
        assert (np.diff(rod.arc_lengths_mm) <= 2.0 + 1e-9).all()
        assert rod.outer_radius_mm == tube["OD"] / 2
        np.testing.assert_allclose(np.linalg.norm(rod.tangents, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(shape.rods[0].points_patient_mm[-1], CASE["tip_p"], atol=1e-6)
    np.testing.assert_allclose(
        shape.rods[0].points_patient_mm[0], shape.rods[1].points_patient_mm[-1], atol=1e-12
    )


def test_tangents_are_the_points_derivatives():
    (rod, *_) = shape_of(reference_robot(CASE), reference_joints(CASE)).rods
    steps = np.diff(rod.points_patient_mm, axis=0) / np.diff(rod.arc_lengths_mm)[:, None]
    means = (rod.tangents[1:] + rod.tangents[:-1]) / 2
    np.testing.assert_allclose(steps, means, atol=2e-3)


def test_tubes_that_end_together_show_the_outer_one_alone():
    robot = tubes_of((40.0, 40.0, 0.012), (40.0, 30.0, 0.009))
    shape = shape_of(robot, joint_values([0.3, 1.1], [-40.0, -30.0]))
    assert [rod.name for rod in shape.rods] == ["tube 2"]


def test_strain_is_radius_times_change_of_curvature():
    """Two tubes in one plane: each is bent from its own curvature to the common one."""
    robot = tubes_of((40.0, 40.0, 0.012), (40.0, 40.0, 0.003))
    shape = shape_of(robot, joint_values([0.0, 0.0], [-40.0, -40.0]))
    inner, outer = (tube.bending_stiffness for tube in robot.tubes)
    bend = (inner * 0.012 + outer * 0.003) / (inner + outer)
    for name, own, tube in zip(("tube 1", "tube 2"), (0.012, 0.003), robot.tubes, strict=True):
        strain = figure(shape, f"bending strain of {name}")
        assert strain.value == pytest.approx(100 * abs(bend - own) * tube.radius_mm, rel=1e-9)
        assert strain.unit == "%"


def test_a_curve_behind_the_entry_is_held_straight():
    robot = tubes_of((40.0, 40.0, 0.012), (30.0, 40.0, 0.003))
    shape = shape_of(robot, joint_values([0.0, 0.0], [-60.0, -60.0]))
    strain = figure(shape, "bending strain of tube 1").value
    assert strain == pytest.approx(100 * 0.012 * robot.tubes[0].radius_mm, rel=1e-9)


def test_figures_tell_stability_and_residual():
    shape = shape_of(reference_robot(CASE), reference_joints(CASE))
    least = figure(shape, "least stability determinant").value
    assert least == pytest.approx(CASE["min_det"], abs=1e-7)
    assert figure(shape, "stability determinant").value > least
    assert figure(shape, "residual").value < 1e-4


def test_several_shapes_and_what_is_simulated_are_said():
    stable = shape_of(reference_robot(CASE), reference_joints(CASE))
    assert "at these translations every rotation has one shape" in stable.origin.notices
    tubes = tubes_of((40.0, 80.0, 0.03), (40.0, 80.0, 0.03)).tubes
    made_up = ConcentricTubeRobot(tubes, np.eye(4), Origin("made up", simulated=True))
    shape = shape_of(made_up, joint_values([0.0, 0.4], [-30.0, -30.0]))
    assert shape.status == "solved" and shape.origin.simulated
    assert any("several stable shapes" in notice for notice in shape.origin.notices)


@pytest.mark.parametrize(("turn", "is_told"), [(0.0, False), (np.pi, True)])
def test_a_tube_strained_beyond_its_material_is_told_first(turn, is_told):
    """A soft tube against a stiff one that curves the other way: (0.16 + 0.4) / mm at 0.45 mm."""
    robot = tubes_of((0.0, 4.0, 0.4), (0.0, 3.0, 0.28))
    shape = shape_of(robot, joint_values([0, turn], [0, 0]))
    told = [notice for notice in shape.origin.notices if "tube 1 is strained by 25" in notice]
    assert shape.status == "solved" and bool(told) == is_told


def test_what_was_asked_for_stands_in_the_shape():
    shape = shape_of(reference_robot(CASE), reference_joints(CASE))
    given = {one.name: one.value for one in shape.given}
    for n, (theta, beta) in enumerate(zip(CASE["theta"], CASE["beta"], strict=True), 1):
        assert given[f"rotation of tube {n}"] == pytest.approx(np.degrees(theta))
        assert given[f"translation of tube {n}"] == beta
