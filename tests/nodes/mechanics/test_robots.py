"""No impossible robot can be made; stiffness is that of the textbook's round tube."""

import numpy as np
import pytest
from scipy import integrate

from nodes.errors import BadInput
from nodes.mechanics.robots import CrispConfiguration, Material, PointLoad, Snare
from tests.nodes.mechanics.made_robots import concentric_tubes, crisp, needle, tube


def refused(make, *told: str) -> None:
    with pytest.raises(BadInput) as caught:
        make()
    for part in told:
        assert part in str(caught.value)


def test_bending_stiffness_is_the_second_moment_of_the_ring():
    """Integrated over the cross-section in polar coordinates."""
    moment, _ = integrate.dblquad(
        lambda r, angle: (r * np.sin(angle)) ** 2 * r, 0, 2 * np.pi, 0.4, 0.55
    )
    assert tube(0.8, 1.1).bending_stiffness == pytest.approx(60000 * moment, rel=1e-12)
    assert tube(0.8, 1.1).radius_mm == 0.55


def test_torsional_stiffness_is_shear_modulus_times_polar_moment():
    polar, _ = integrate.dblquad(lambda r, angle: r**3, 0, 2 * np.pi, 0.485, 0.635)
    shear_modulus = 60000 / (2 * 1.3)
    assert needle().torsional_stiffness == pytest.approx(shear_modulus * polar, rel=1e-12)


@pytest.mark.parametrize(
    "wrong", [(0.0, 0.3, 0.1), (np.nan, 0.3, 0.1), (1.0, 0.6, 0.1), (1.0, -0.1, 0.1), (1.0, 0.3, 0)]
)
def test_material_constants_out_of_range_are_refused(wrong):
    refused(lambda: Material("odd", *map(float, wrong)), " = ", "finite number")


def test_a_curve_beyond_the_recoverable_strain_is_refused_with_the_largest_curvature():
    """5 % on a tube of 1.1 mm: curvature 2 x 0.05 / 1.1 = 0.0909."""
    tube(curvature=0.0909)
    tube(curvature=-0.0909)
    refused(lambda: tube(curvature=0.1), "curvature_per_mm = 0.1", "5.50%", "5.00%", "0.09091")
    refused(lambda: tube(curvature=-0.1), "5.50%")
    refused(lambda: tube(curvature=np.nan), "curvature_per_mm = nan")


def test_twist_strains_a_needle_as_shear():
    """Pure shear g = tau OD / 2 has the largest strain g / 2."""
    needle((0, 0, 2 * 0.05 * 2 / 1.27 * 0.999))
    refused(lambda: needle((0, 0, 2 * 0.05 * 2 / 1.27 * 1.001)), "precurvature_per_mm", "twist")
    refused(lambda: needle((0.06, 0.06, 0)), "precurvature_per_mm = 0.0848528")


def test_a_robot_keeps_the_rules_of_its_nest():
    concentric_tubes()
    refused(lambda: concentric_tubes(tubes=()), "0 tubes")
    refused(lambda: concentric_tubes(tubes=(tube(), tube(1.0, 1.4))), "1.1 mm", "1 mm", "fits")
    mirrored = np.diag([1.0, 1, -1, 1])
    refused(lambda: concentric_tubes(patient_from_base=mirrored), "patient_from_base", "mirrored")
    limits = np.array([[-10.0, 0]])
    refused(lambda: concentric_tubes(translation_limits_mm=limits), "translation_limits_mm: 1")


def test_a_setup_keeps_the_rules_of_its_snares():
    crisp()
    crisp(needles=(needle(),), snares=(), entry_points_patient_mm=np.zeros((1, 3)))
    refused(lambda: crisp(snares=(Snare(1, 120.0),)), "needle 2 grasps 0 times")
    refused(lambda: crisp(entry_points_patient_mm=np.eye(3)[:2]), "entry_points_patient_mm: 2")
    refused(lambda: crisp(entry_points_patient_mm=np.full((3, 3), np.nan)), "finite")
    for angle in (0.0, 180.0, np.nan):
        refused(lambda angle=angle: crisp(field_of_view_deg=angle), "field_of_view_deg")


def test_loads_and_orientations_are_numbers_and_rotations():
    zero = np.zeros(3)
    refused(lambda: PointLoad(-1.0, zero, zero), "arc_length_mm = -1 mm")
    refused(lambda: PointLoad(1.0, np.array([0, np.nan, 0]), zero), "force_n")
    refused(lambda: CrispConfiguration(np.ones((1, 3, 3)), np.ones(1)), "patient_from_entry[0]")


def test_arrays_of_robots_are_read_only():
    with pytest.raises(ValueError, match="read-only"):
        crisp().entry_points_patient_mm[0, 0] = 1
