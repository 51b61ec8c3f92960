"""What joints demand, against SciPy's rotations and finite differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nodes.kernels.crisp_joints import joint_residual, joint_rows

SNARE_FROM_TOOL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # R_x of [Kuntz2017] eq. (6)


def state(point, turn):
    return np.concatenate([point, turn.T.ravel()])


def pose(seed):
    chance = np.random.default_rng(seed)
    return chance.normal(size=3), Rotation.random(rng=chance).as_matrix()


def residual(tool, snare, moment, rigid, cosine=0.2):
    out = np.empty(6)
    joint_residual(state(*tool), state(*snare), moment, rigid, cosine, out)
    return out


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-5, 0.3, 2.0, 3.0, np.pi - 1e-6])
def test_rigid_joint_measures_the_rotation_vector(angle):
    (p, turn), (q, other) = pose(1), pose(2)
    axis = other[:, 0]
    held = Rotation.from_rotvec(angle * axis).as_matrix() @ turn @ SNARE_FROM_TOOL.T
    found = residual((p, turn), (q, held), np.zeros(3), True)
    assert found[:3] == pytest.approx(q - p)
    assert found[3:] == pytest.approx(angle * axis, abs=1e-9)


def test_mirrored_rigid_joint_is_no_joint():
    p, turn = pose(3)
    for flip in np.eye(3):
        held = turn @ Rotation.from_rotvec(np.pi * flip).as_matrix() @ SNARE_FROM_TOOL.T
        found = residual((p, turn), (p, held), np.zeros(3), True)
        assert np.linalg.norm(found[3:]) > 3 or not np.isfinite(found).all()


def test_held_rigid_joint_points_the_snare_against_d2():
    p, turn = pose(4)
    held = turn @ SNARE_FROM_TOOL.T
    assert held[:, 2] == pytest.approx(-turn[:, 1]) and held[:, 1] == pytest.approx(turn[:, 2])
    assert np.abs(residual((p, turn), (p, held), np.ones(3), True)).max() < 1e-14


def test_relaxed_joint_measures_angle_and_moments_about_the_tangents():
    (p, turn), (q, other), moment = pose(5), pose(6), np.array([1.0, -2, 3])
    wanted = [
        turn[:, 2] @ other[:, 2] - 0.2, other[:, 2] @ moment, turn[:, 2] @ moment,
    ]  # fmt: skip
    assert residual((p, turn), (q, other), moment, False)[3:] == pytest.approx(wanted)


@pytest.mark.parametrize("rigid", [True, False])
@pytest.mark.parametrize("seed", range(5))
def test_rows_are_finite_differences(seed, rigid):
    tool, snare = pose(seed), pose(seed + 50)
    moment = np.random.default_rng(seed).normal(size=3)
    blocks, step = np.empty((3, 3, 3)), 1e-6
    at = residual(tool, snare, moment, rigid)
    joint_rows(state(*tool), state(*snare), moment, rigid, at, blocks)
    for axis, unit in enumerate(np.eye(3)):
        turns = [Rotation.from_rotvec(sign * step * unit).as_matrix() for sign in (1, -1)]
        changed = (
            [residual((tool[0], turn @ tool[1]), snare, moment, rigid) for turn in turns],
            [residual(tool, (snare[0], turn @ snare[1]), moment, rigid) for turn in turns],
            [residual(tool, snare, moment + sign * step * unit, rigid) for sign in (1, -1)],
        )
        for block, (ahead, back) in zip(blocks, changed, strict=True):
            assert block[:, axis] == pytest.approx((ahead - back)[3:] / (2 * step), abs=1e-6)
