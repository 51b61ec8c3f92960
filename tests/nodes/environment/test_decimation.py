"""Fewer triangles, still closed; moved surfaces enclose what they should."""

import numpy as np
import pytest
import trimesh

from nodes.environment.decimation import decimate, is_closed, move_to_volume


def torus():
    solid = trimesh.creation.torus(20, 6, major_sections=90, minor_sections=40)
    return np.array(solid.vertices), np.array(solid.faces), solid


@pytest.mark.parametrize("wanted", [300, 1000, 4001])
def test_the_wanted_count_is_reached_within_a_hundredth_and_the_surface_stays_closed(wanted):
    vertices, triangles, _ = torus()
    vertices, triangles = decimate(vertices, triangles, wanted)
    assert 0.99 * wanted - 2 <= len(triangles) <= wanted
    assert trimesh.Trimesh(vertices, triangles, process=False).is_watertight


def test_a_surface_with_fewer_triangles_stays_as_it_is():
    vertices, triangles, _ = torus()
    same, kept = decimate(vertices, triangles, 1_000_000)
    assert same is vertices and kept is triangles


def test_closed_means_that_each_edge_is_used_once_each_way():
    box = np.array(trimesh.creation.box().faces)
    assert is_closed(box)
    assert not is_closed(box[1:])
    assert not is_closed(np.concatenate([box, box]))
    assert not is_closed(np.concatenate([box[:1, ::-1], box[1:]]))
    assert not is_closed(np.empty((0, 3), int))


@pytest.mark.parametrize("change", [-0.05, 0.0, 0.05])
def test_moved_surfaces_enclose_the_volume_and_move_alike(change):
    vertices, triangles, solid = torus()
    wanted = solid.volume * (1 + change)
    moved = move_to_volume(vertices, triangles, wanted, 2.0)
    after = trimesh.Trimesh(moved, triangles, process=False)
    assert after.volume == pytest.approx(wanted, rel=1e-9)
    away = np.linalg.norm(moved - vertices, axis=1)
    np.testing.assert_allclose(away, abs(change) * solid.volume / solid.area, atol=0.005)


def test_no_vertex_moves_further_than_allowed():
    vertices, triangles, solid = torus()
    moved = move_to_volume(vertices, triangles, 2 * solid.volume, 0.25)
    np.testing.assert_allclose(np.linalg.norm(moved - vertices, axis=1), 0.25, rtol=1e-3)
