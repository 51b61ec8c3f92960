"""The phantom's lungs, whatever the build: between the ribs, apart, and as small as asked."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from nodes.imaging.solids import join, tube
from nodes.imaging.thorax_anatomy import Build, draw_build
from nodes.imaging.thorax_bones import RIB_HEIGHT, RIB_PAIRS, RIB_RADIUS, _rib
from nodes.imaging.thorax_lungs import HEALTHY, draw_in, lung, pleural_cavity

AXES = [np.arange(a, b, 5.0, dtype=np.float32) for a, b in ((-150, 150), (-110, 110), (-150, 150))]
POINTS = (AXES[0][:, None, None], AXES[1][None, :, None], AXES[2][None, None, :])
seeds = st.integers(0, 10**6)


@settings(max_examples=6, deadline=None)
@given(seed=seeds)
def test_no_rib_cuts_a_lung(seed):
    build = draw_build(1.0, seed)
    ribs = [join(tube(_rib(n, side, build.rib_slope)[0], RIB_RADIUS, RIB_HEIGHT))
            for n in range(RIB_PAIRS) for side in (-1, 1)]  # fmt: skip
    cavities = [pleural_cavity(side, build).distance(POINTS) < 0 for side in (-1, 1)]
    assert not (cavities[0] & cavities[1]).any()
    bone = join(ribs).distance(POINTS) < 0
    assert bone.sum() > 500
    assert not (bone & (cavities[0] | cavities[1])).any()


@settings(max_examples=4, deadline=None)
@given(
    seed=seeds,
    share=st.floats(0.05, 0.7),
    side=st.sampled_from([-1, 1]),
    film=st.sampled_from([0.0, 3.0]),
)
def test_a_collapsed_lung_is_as_small_as_asked_and_stays_in_its_cavity(seed, share, side, film):
    build = draw_build(1.0, seed)
    collapse = draw_in(side, build, "posterior", share, film)
    cavity = pleural_cavity(side, build).distance(POINTS) < 0
    small = lung(side, build, collapse).distance(POINTS) < 0
    assert not (small & ~cavity).any()
    assert 1 - small.sum() / cavity.sum() == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(("film", "least"), [(0.0, 0.0), (4.0, 0.9)])
def test_fluid_is_no_film_where_none_is_asked_for(film, least):
    """A ball of 1.5 mm fits into the fluid nearly everywhere, or, with films, not."""
    build = draw_build(0.5, 3)
    lowered = [np.arange(a, b, 1.0, dtype=np.float32) for a, b in ((0, 150), (0, 110), (-60, 20))]
    points = np.ix_(*lowered)
    inside = pleural_cavity(1, build).distance(points) < 0
    collapse = draw_in(1, build, "posterior", 0.15, film)
    fluid = inside & ~(lung(1, build, collapse).distance(points) < 0)
    room = ndimage.distance_transform_edt(np.pad(fluid, 3, "edge"))[3:-3, 3:-3, 3:-3] >= 1.5
    reached = ndimage.distance_transform_edt(~room) < 1.5
    share = (fluid & reached).sum() / fluid.sum()
    assert share > least if film else share < 0.8


def test_without_fluid_nothing_is_drawn_in():
    assert draw_in(1, Build(), "posterior", 0.0, 3.0) == HEALTHY
    course = np.array([(1.0, 2, 3), (4, 5, 6)])
    np.testing.assert_array_equal(HEALTHY.move(course), course)


@given(seed=seeds)
def test_half_the_variation_is_half_the_difference(seed):
    average, half, full = (np.array(draw_build(v, seed)) for v in (0.0, 0.5, 1.0))
    np.testing.assert_allclose(average, Build())
    np.testing.assert_allclose(half - average, (full - average) / 2)
