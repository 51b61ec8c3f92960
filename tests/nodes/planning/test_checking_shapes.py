"""Needles are looked at in places that fit together along a motion, in the shapes of mechanics."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Snare
from nodes.mechanics.solve_crisp import solve_crisp
from nodes.planning.checking_shapes import follow_motion, place_samples, rest_at_start
from nodes.planning.checking_steps import FineMotion, cut_finely
from tests.nodes.planning.made_motions import GOOD, NEEDLE, PARAMETERS, SETUP, make_frames, move


@given(hnp.arrays(float, st.integers(1, 4), elements=st.floats(0.5, 300)))
def test_places_reach_from_entry_to_tip_no_farther_apart_than_asked(lengths) -> None:
    arcs = place_samples(lengths, PARAMETERS)
    assert (arcs[:, 0] == 0).all()
    assert arcs[:, -1] == pytest.approx(lengths)
    steps = np.diff(arcs, axis=1)
    assert (steps >= -1e-9).all() and steps.max() <= PARAMETERS.sample_spacing_mm + 1e-9
    for own, length in zip(arcs, lengths, strict=True):
        assert min(PARAMETERS.sheath_mm, length) in own


def test_what_is_followed_is_what_mechanics_finds_alone() -> None:
    motion = move(**GOOD)
    fine = cut_finely(motion, 3)
    found = follow_motion(SETUP, fine, motion.wrenches[0], PARAMETERS)
    assert found.lost == "" and len(found.margins) == 16
    for row in (0, 7, 15):
        configuration = CrispConfiguration(fine.orientations[row], fine.lengths_mm[row])
        alone = solve_crisp(SETUP, configuration, PARAMETERS)
        assert found.cameras[row] == pytest.approx(alone.patient_from_camera, abs=1e-5)
        assert found.wrenches[row] == pytest.approx(alone.base_wrenches, abs=1e-5)
        # At most the margin, and the strain but for what lies between samples.
        gap = alone.stability_margin - found.margins[row]
        assert -1e-9 <= gap <= 2 * PARAMETERS.margin_accuracy
        assert found.strains[row] == pytest.approx(alone.bending_strains, rel=0.05, abs=1e-6)
        for course, rod in zip(found.courses, alone.rods, strict=True):
            tip = course.points[row, -1] - rod.points_patient_mm[-1]
            assert np.abs(tip).max() < 1e-5


def test_the_rest_at_the_start_does_not_depend_on_what_is_claimed() -> None:
    motion = move(**GOOD)
    rest = rest_at_start(SETUP, cut_finely(motion, 2), PARAMETERS)
    assert rest.status == "solved"
    assert rest.base_wrenches == pytest.approx(motion.wrenches[0], abs=1e-6)


def test_snares_that_pass_each_other_on_the_tool_are_a_refusal_and_no_error() -> None:
    """One holds the tool's material, the other a place from its entry: the tool slides through."""
    joints = (Snare(1, 10.0, "tip", "relaxed"), Snare(2, 60.5, "entry", "relaxed"))
    entries = np.array([[0.0, 0, 0], [60, 0, 60], [-60, 0, 60]])
    setup = CrispSetup((NEEDLE,) * 3, entries, joints, 80.0)
    frames = np.repeat(make_frames()[[0, 1, 1]][None], 2, 0)
    fine = FineMotion(np.arange(2.0), frames, np.array([[70.0, 60, 60], [71.0, 60, 60]]))
    found = follow_motion(setup, fine, np.zeros((3, 6)), PARAMETERS)
    assert "at step 0 the robot finds no stable shape" in found.lost and not len(found.margins)
