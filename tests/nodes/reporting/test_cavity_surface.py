import numpy as np
import pytest
import trimesh

from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.reporting.cavity_surface import draw_cavity
from tests.nodes.reporting import made_plans


def make_ball(radius_mm, spacing=(1.0, 1.0, 1.0), flip=False):
    affine = np.diag([*spacing, 1.0])
    shape = [int(2 * (radius_mm + 4) / step) for step in spacing]
    affine[:3, 3] = -np.array(spacing) * (np.array(shape) - 1) / 2 + [100, -50, 30]
    if flip:
        affine[0] = -affine[0] + [0, 0, 0, 200]
    indices = np.moveaxis(np.indices(shape), 0, -1)
    points = indices @ affine[:3, :3].T + affine[:3, 3]
    distance = radius_mm - np.linalg.norm(points - [100, -50, 30], axis=-1)
    return Volume(distance.astype(np.float32), affine, "mm", Origin("a ball"))


def to_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices_patient_mm, mesh.triangles, process=False)


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("spacing", [(1, 1, 1), (1, 1.5, 2)])
def test_a_ball_is_drawn_as_a_closed_ball_that_winds_outward(spacing, flip):
    mesh = draw_cavity(make_ball(20, spacing, flip), cell_mm=2.0, smoothing_mm=0.0)
    drawn = to_trimesh(mesh)
    radii = np.linalg.norm(mesh.vertices_patient_mm - [100, -50, 30], axis=1)
    assert drawn.is_watertight and drawn.volume > 0
    assert radii == pytest.approx(np.full(len(radii), 20), abs=0.15)


def test_larger_cells_give_fewer_triangles():
    ball = make_ball(20)
    fine, coarse = (draw_cavity(ball, cell, 1.0).triangles for cell in (1.0, 3.0))
    assert len(coarse) < len(fine) / 4


def test_a_space_that_reaches_the_grids_end_is_closed_there():
    ball = make_ball(20)
    half = Volume(ball.voxels[:24], ball.patient_from_index, "mm", ball.origin)
    drawn = to_trimesh(draw_cavity(half, 1.0, 0.5))
    whole = 4 / 3 * np.pi * 20**3
    assert drawn.is_watertight and drawn.volume == pytest.approx(whole / 2, rel=0.06)


def test_nothing_free_has_no_surface():
    ball = make_ball(20)
    full = Volume(-np.abs(ball.voxels) - 1, ball.patient_from_index, "mm", ball.origin)
    assert len(draw_cavity(full, 2.0, 1.0).triangles) == 0


def test_the_made_cavity_has_about_its_volume():
    drawn = to_trimesh(draw_cavity(made_plans.make_distance(), 2.5, 1.0))
    volume = 4 / 3 * np.pi * made_plans.HALVES_MM.prod()
    assert drawn.volume == pytest.approx(volume, rel=0.05)
