"""Numbers of a motion's mechanics are those of closed forms; snaps are told."""

import numpy as np
import pytest

from nodes.planning.checking_mechanics import _differ, check_mechanics
from nodes.planning.checking_shapes import follow_motion
from nodes.planning.checking_steps import cut_finely
from tests.nodes.planning.made_motions import GOOD, PARAMETERS, SETUP, move, plan

MOTION = move(**GOOD)
FINE = cut_finely(MOTION, 4)
FOLLOWED = follow_motion(SETUP, FINE, MOTION.wrenches[0], PARAMETERS)
PLAN = plan(MOTION, np.zeros((0, 3), int))


def test_a_motion_as_it_was_solved_breaks_nothing() -> None:
    failures, figures = check_mechanics(PLAN, FINE, FOLLOWED, PARAMETERS)
    told = {figure.name: figure.value for figure in figures}
    assert failures == []
    places = MOTION.patient_from_camera[:, :3, 3]
    strides = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert told["largest motion of the camera in a step"] == pytest.approx(strides.max(), abs=1e-5)
    assert strides.sum() - 1e-5 <= told["way of the camera"] < 1.01 * strides.sum()
    assert told["largest difference to the planner"] < 1e-5


@pytest.mark.parametrize("row", [3, 12])
def test_a_camera_that_jumps_further_than_the_joints_move_is_a_snap(row) -> None:
    cameras = np.array(FOLLOWED.cameras)
    cameras[row:, 0, 3] += 20.0
    failures, _ = check_mechanics(PLAN, FINE, FOLLOWED._replace(cameras=cameras), PARAMETERS)
    step = (row - 1) // 4
    assert f"between steps {step} and {step + 1} the robot snaps" in failures[0]


def test_differences_of_wrenches_count_as_what_they_move_a_cantilever() -> None:
    """A moment M on a cantilever moves its end by M L^2 / 2 E I, a force F by F L^3 / 3 E I."""
    stiffness = 50000 * np.pi / 64 * (1.02**4 - 0.84**4)
    one, other = np.zeros((2, 6)), np.zeros((2, 6))
    other[1, 1] = 2.0
    assert _differ(SETUP, one, other, 100.0) == pytest.approx(2.0 * 100**2 / 2 / stiffness)
    other[0, 5] = 0.5
    assert _differ(SETUP, one, other, 100.0) == pytest.approx(0.5 * 100**3 / 3 / stiffness)


def test_another_shape_of_less_energy_at_the_start_is_told() -> None:
    claimed = FOLLOWED._replace(wrenches=FOLLOWED.wrenches + 0.05)
    failures, _ = check_mechanics(PLAN, FINE, claimed, PARAMETERS)
    assert any("rests in another shape" in each for each in failures)
