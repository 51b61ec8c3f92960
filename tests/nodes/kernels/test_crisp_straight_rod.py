"""One rod against closed forms, SciPy's integrator and finite differences."""

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from nodes.kernels.crisp_lanes import LANES, load, make_lanes
from nodes.kernels.crisp_lanes_vectors import load_vector, store_vector
from nodes.kernels.crisp_straight_rod import ROD_ROWS, follow_rod, follow_rod_columns

BENDING, TORSION = 1.3, 0.9


@njit(cache=True)
def call(rows, framed, steps, work, columns, out):
    t, d = load_vector(rows, 0), load_vector(rows, 3)
    m, n = load_vector(rows, 6), load_vector(rows, 9)
    if len(columns):
        end = follow_rod_columns(t, d, m, n, load(rows, 12), BENDING, TORSION, steps, work, columns)
    else:
        end = follow_rod(t, d, m, n, load(rows, 12), BENDING, TORSION, framed, steps, work)
    for axis in range(3):
        store_vector(out, 3 * axis, end[axis])


def follow(rows, framed=True, steps=8, columns=None):
    out = make_lanes(9)
    columns = make_lanes(0) if columns is None else columns
    call(rows, framed, steps, make_lanes(ROD_ROWS), columns, out)
    return out


def rods(seed=0, force=1.0, moment=1.0):
    """Return tangent +z, axis +x, moment, force and length of a rod in each lane."""
    rows = make_lanes(13)
    rng = np.random.default_rng(seed)
    rows[2] = rows[3] = 1.0
    rows[6:9] = moment * rng.normal(size=(3, LANES))
    rows[9:12] = force * rng.normal(size=(3, LANES))
    rows[12] = rng.uniform(0.5, 1.5, LANES)
    return rows


def test_a_moment_alone_bends_an_arc():
    rows = rods(force=0.0)
    rows[6] = rows[8] = 0.0
    radius = BENDING / rows[7]
    angle = rows[12] / radius
    end = follow(rows)
    assert np.abs(end[0] - radius * (1 - np.cos(angle))).max() < 1e-11
    assert np.abs(end[2] - radius * np.sin(angle)).max() < 1e-11
    assert np.abs(end[3] - np.sin(angle)).max() < 1e-11


def test_torsion_alone_twists_by_the_torsional_stiffness():
    rows = rods(force=0.0)
    rows[6] = rows[7] = 0.0
    angle = rows[8] * rows[12] / TORSION
    end = follow(rows)
    assert np.abs(end[6:] - [np.cos(angle), np.sin(angle), 0 * angle]).max() < 1e-11
    assert np.abs(end[2] - rows[12]).max() < 1e-13


def test_rods_agree_with_scipy_in_all_lanes():
    rows = rods(seed=3, force=2.0)
    end = follow(rows)
    for lane in range(0, LANES, 5):
        m0, n, length = rows[6:9, lane], rows[9:12, lane], rows[12, lane]

        def slope(_, y, m0=m0, n=n):
            frame = y[3:].reshape(3, 3)
            m = frame.T @ (m0 + np.cross(n, y[:3]))
            u = m / [BENDING, BENDING, TORSION]
            hat = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
            return np.concatenate([frame[:, 2], (frame @ hat).ravel()])

        start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
        slow = solve_ivp(slope, (0, length), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        frame = slow[3:].reshape(3, 3)
        wanted = np.concatenate([slow[:3], frame[:, 2], frame[:, 0]])
        assert np.abs(end[:, lane] - wanted).max() < 1e-9


def test_without_frame_place_and_tangent_are_the_same():
    rows = rods(seed=1)
    assert np.abs(follow(rows)[:6] - follow(rows, framed=False)[:6]).max() < 1e-14


def test_error_falls_with_the_eighth_power_of_the_step():
    rows = rods(seed=5, moment=2.0)
    exact = follow(rows, steps=32)
    errors = [np.abs(follow(rows, steps=steps) - exact).max() for steps in (2, 4)]
    assert errors[0] / errors[1] > 2**7


@pytest.mark.parametrize("component", range(6))
def test_columns_are_finite_differences_of_the_end(component):
    rows, columns, step = rods(seed=7), make_lanes(36), 1e-5
    end = follow(rows, columns=columns)
    ahead, behind = rows.copy(), rows.copy()
    ahead[6 + component] += step
    behind[6 + component] -= step
    change = (follow(ahead) - follow(behind)) / (2 * step)
    way, turn = columns[6 * component : 6 * component + 3], columns[6 * component + 3 :][:3]
    assert np.abs(way - change[:3]).max() < 1e-8
    assert np.abs(np.cross(turn, end[3:6], axis=0) - change[3:6]).max() < 1e-8
    assert np.abs(np.cross(turn, end[6:9], axis=0) - change[6:9]).max() < 1e-8
