"""Smoothing takes noise away and leaves size and place."""

import numpy as np
import trimesh

from nodes.environment.smoothing import smooth_surface


def noisy_sphere():
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=20.0)
    noise = np.random.default_rng(0).normal(size=len(sphere.vertices)) * 0.3
    vertices = sphere.vertices * (1 + noise / 20)[:, None]
    return np.array(vertices), np.array(sphere.faces), sphere


def test_noise_shrinks_and_the_volume_stays():
    vertices, triangles, sphere = noisy_sphere()
    smooth = smooth_surface(vertices, triangles, 10)
    before, after = (np.linalg.norm(v, axis=1) for v in (vertices, smooth))
    assert after.std() < 0.4 * before.std()
    volume = trimesh.Trimesh(smooth, triangles, process=False).volume
    assert abs(volume / sphere.volume - 1) < 0.01


def test_no_steps_change_nothing_and_a_step_follows_the_formula():
    vertices, triangles, _ = noisy_sphere()
    np.testing.assert_array_equal(smooth_surface(vertices, triangles, 0), vertices)
    neighbours = [set() for _ in vertices]
    for a, b, c in triangles:
        neighbours[a] |= {b, c}
        neighbours[b] |= {a, c}
        neighbours[c] |= {a, b}
    moved = vertices
    for step in (0.5, -0.53):
        means = np.stack([moved[list(near)].mean(axis=0) for near in neighbours])
        moved = moved + step * (means - moved)
    np.testing.assert_allclose(smooth_surface(vertices, triangles, 1), moved, atol=1e-9)
