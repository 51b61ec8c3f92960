"""What is touched is said with the needle, the step, the place and the rule."""

import numpy as np
import pytest

from nodes.planning.checking_boxes import make_boxes
from nodes.planning.checking_shapes import follow_motion
from nodes.planning.checking_steps import cut_finely
from nodes.planning.checking_touches import Space, Touches, check_touches
from tests.nodes.planning.made_motions import GOOD, PARAMETERS, SETUP, bone_map, box_grid, move

MOTION = move(**GOOD)
FINE = cut_finely(MOTION, 4)
FOLLOWED = follow_motion(SETUP, FINE, MOTION.wrenches[0], PARAMETERS)


def touches(walls=(), bone=(), followed=FOLLOWED, **changed) -> Touches:
    grid = box_grid(walls)
    boxes = make_boxes(~grid.mask("free"), grid.patient_from_index, outside=True)
    parameters = PARAMETERS.model_copy(update=changed)
    return check_touches(SETUP, FINE, followed, Space(boxes, bone_map(*bone)), parameters)


def test_in_free_space_nothing_is_touched() -> None:
    found = touches()
    assert found.failures == [] and np.isfinite(found.clearances_mm).all()
    # Without any bone in reach there is no distance to tell.
    assert not any("sheaths to" in figure.name for figure in found.figures)


def test_each_needle_that_touches_is_said_once_with_its_place() -> None:
    (told,) = touches([((20, -8, 57), (24, 8, 63))]).failures
    assert "the snare 1 touches anatomy" in told and "at least 0.25 mm" in told
    arc = float(told.split("anatomy, ")[1].split(" mm")[0])
    assert 60 - 24 - 2 < arc < 60 - 20 + 2


def test_less_than_the_margin_is_told_with_its_size() -> None:
    free = touches([((20, -8, 63), (24, 8, 66))])
    least = free.clearances_mm.min()
    assert free.failures == [] and least > PARAMETERS.margin_mm
    wanted = {"margin_mm": least + 0.1, "clear_mm": least + 0.2}
    told = touches([((20, -8, 63), (24, 8, 66))], **wanted).failures
    assert any(f"may come within {least:.3g} mm" in each for each in told)


def test_needles_at_their_grasp_may_touch_and_no_further_away() -> None:
    assert touches(grasp_mm=1.5).failures == []
    (told,) = touches(grasp_mm=0.0).failures
    assert "the tool and the snare 1 touch" in told


def test_clearances_are_missing_where_the_robot_was_lost_before() -> None:
    part = FOLLOWED._replace(
        margins=FOLLOWED.margins[:9],
        courses=tuple(type(c)(*(v[:9] for v in c)) for c in FOLLOWED.courses),
    )
    found = touches(followed=part)
    assert np.isfinite(found.clearances_mm[:3]).all() and np.isnan(found.clearances_mm[3:]).all()


def test_bone_is_as_far_as_its_nearest_voxel() -> None:
    straight = touches(bone=[((-40, -60, -60), (-20, 60, 0))])
    (figure,) = [each for each in straight.figures if "sheaths to bone" in each.name]
    assert figure.value == pytest.approx(20.5 - 0.51, abs=0.6)
