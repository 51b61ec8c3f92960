"""Derivatives of equilibria against finite differences of solutions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.mechanics_cases import random_crisp
from nodes.mechanics.crisp_jacobians import crisp_jacobians
from nodes.mechanics.solve_crisp import solve_crisp
from tests.nodes.mechanics import oracle_crisp
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, case_wrenches, parameters
from tests.nodes.mechanics.oracle_crisp_rods import robot_of

# Loads and joints at the tip or on each other have derivatives to one side only.
SMOOTH = [
    "rigid1_load_1",
    "relaxed1_3",
    "relaxed2_paper_load_0",
    "mixed2_load_1",
    "precurved1_1",
    "cantilever_3d_force_5mm",
]
STEP = 1e-4


def turned(configuration, needle, axis, angle):
    rotations = np.array(configuration.patient_from_entry)
    rotations[needle] = (
        Rotation.from_rotvec(angle * np.eye(3)[axis]).as_matrix() @ rotations[needle]
    )
    return replace(configuration, patient_from_entry=rotations)


def longer(configuration, needle, way):
    lengths = np.array(configuration.lengths_mm)
    lengths[needle] += way
    return replace(configuration, lengths_mm=lengths)


def shifted(setup, needle, axis, way):
    entries = np.array(setup.entry_points_patient_mm)
    entries[needle, axis] += way
    return replace(setup, entry_points_patient_mm=entries)


def opened(setup, number, change, name):
    snares = list(setup.snares)
    snares[number] = replace(snares[number], **{name: getattr(snares[number], name) + change})
    return replace(setup, snares=tuple(snares))


def loaded(configuration, number, axis, change):
    loads = list(configuration.loads)
    name = "moment_n_mm" if axis < 3 else "force_n"
    vector = np.array(getattr(loads[number], name))
    vector[axis % 3] += change
    loads[number] = replace(loads[number], **{name: vector})
    return replace(configuration, loads=tuple(loads))


def along_tool(setup):
    """Return the setup's snares in their order along the tool; grasps are from the tip."""
    return sorted(range(len(setup.snares)), key=lambda n: -setup.snares[n].grasp_mm)


def differences(setup, configuration, change, wrenches):
    """Return the camera's and the base wrenches' central differences; change(step) makes both."""
    found = [
        solve_crisp(*change(step), parameters(tolerance_mm=1e-11), wrenches)
        for step in (STEP, -STEP)
    ]
    ahead, back = (one.patient_from_camera for one in found)
    turn = Rotation.from_matrix(ahead[:3, :3] @ back[:3, :3].T).as_rotvec()
    pose = np.concatenate([ahead[:3, 3] - back[:3, 3], turn]) / (2 * STEP)
    return pose, (found[0].base_wrenches - found[1].base_wrenches).ravel() / (2 * STEP)


@pytest.mark.parametrize("name", SMOOTH)
def test_derivatives_are_those_of_solutions(name):
    setup, configuration = case_robot(CASES[name], "tip")
    wrenches = solve_crisp(
        setup, configuration, parameters(tolerance_mm=1e-11), case_wrenches(CASES[name])
    ).base_wrenches
    exact = crisp_jacobians(setup, configuration, wrenches, 1e-11)
    n, order = len(setup.needles), along_tool(setup)
    changes = []
    for needle in range(n):
        for axis in range(3):
            column = exact.camera_by_configuration[:, 4 * needle + axis]
            changes.append(
                (column, lambda h, i=needle, j=axis: (setup, turned(configuration, i, j, h)))
            )
            column = exact.camera_by_entry[:, 3 * needle + axis]
            changes.append(
                (column, lambda h, i=needle, j=axis: (shifted(setup, i, j, h), configuration))
            )
        column = exact.camera_by_configuration[:, 4 * needle + 3]
        changes.append((column, lambda h, i=needle: (setup, longer(configuration, i, h))))
    for place, number in enumerate(order):
        column = -exact.camera_by_grasp[:, place]  # nearer to the tip is less grasp_mm
        changes.append(
            (column, lambda h, i=number: (opened(setup, i, h, "grasp_mm"), configuration))
        )
        if setup.snares[number].joint == "relaxed":
            column = exact.camera_by_cosine[:, place]
            changes.append(
                (column, lambda h, i=number: (opened(setup, i, h, "cosine"), configuration))
            )
    for number in range(len(configuration.loads)):
        for axis in range(6):
            column = exact.camera_by_load[:, 6 * number + axis]
            changes.append(
                (column, lambda h, i=number, j=axis: (setup, loaded(configuration, i, j, h)))
            )
    scale = np.repeat([1.0, 100.0], 3)  # mm and rad alike
    for column, change in changes:
        pose, _ = differences(setup, configuration, change, wrenches)
        size = max(np.abs(scale * pose).max(), 1e-2)
        assert np.abs(scale * (pose - column)).max() < 1e-5 * size


@pytest.mark.parametrize("joints, loads, precurved", [(("relaxed",), 1, True)])
def test_camera_moves_as_that_of_slow_solves(joints, loads, precurved):
    setup, configuration = random_crisp(np.random.default_rng(6), joints, loads, precurved)
    found = solve_crisp(setup, configuration, parameters(guesses=0))
    exact = crisp_jacobians(setup, configuration, found.base_wrenches, 1e-9)
    robot = robot_of(setup, configuration)
    slow = oracle_crisp.polish(robot, found.base_wrenches)
    wanted = oracle_crisp.camera_jacobian(setup, configuration, slow)
    scale = np.repeat([1.0, 100.0], 3)[:, None]  # mm and rad alike
    assert (
        np.abs(scale * (exact.camera_by_configuration - wanted)).max()
        < 1e-5 * np.abs(scale * wanted).max()
    )


def test_wrenches_by_configuration_are_those_of_solutions():
    setup, configuration = case_robot(CASES["mixed2_load_1"], "tip")
    wrenches = solve_crisp(setup, configuration, parameters(tolerance_mm=1e-11)).base_wrenches
    exact = crisp_jacobians(setup, configuration, wrenches, 1e-11).wrenches_by_configuration
    for needle in range(3):
        change = lambda h, i=needle: (setup, longer(configuration, i, h))  # noqa: E731
        _, slope = differences(setup, configuration, change, wrenches)
        assert exact[:, 4 * needle + 3] == pytest.approx(slope, rel=1e-5, abs=1e-6)


def test_grasps_from_the_entry_stay_where_they_are():
    case = CASES["relaxed1_1"]
    setup, configuration = case_robot(case, "entry")
    wrenches = case_wrenches(case)
    exact = crisp_jacobians(setup, configuration, wrenches, 1e-9)
    tip = np.array(case["out"]["tip_R"])[:, 2]
    # A longer tool then only reaches on past the joint, straight ahead.
    assert exact.camera_by_configuration[:, 3] == pytest.approx([*tip, 0, 0, 0], abs=1e-9)
    held = crisp_jacobians(*case_robot(case, "tip"), wrenches, 1e-9)
    assert (
        np.abs(held.camera_by_configuration[:, 3] - exact.camera_by_configuration[:, 3]).max() > 0.1
    )


def test_rows_at_held_wrenches_add_up():
    case = CASES["mixed2_load_1"]
    setup, configuration = case_robot(case, "tip")
    exact = crisp_jacobians(setup, configuration, case_wrenches(case), 1e-9)
    moved = exact.residual_by_wrenches @ exact.wrenches_by_configuration
    assert moved + exact.residual_by_configuration == pytest.approx(0, abs=1e-8)
    assert exact.joints_by_wrenches.shape == (2, 6, 18)
    # A wrench at a snare's base does nothing to the tool before its joint.
    assert np.abs(exact.joints_by_wrenches[0][:, 6:]).max() == 0
    assert np.abs(exact.joints_by_wrenches[1][:, 6:12]).max() > 0
