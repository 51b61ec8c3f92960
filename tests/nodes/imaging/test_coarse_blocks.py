"""Blocks of voxels against loops."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.imaging.coarse_blocks import block_sums, coarse_step, refined

arrays_of_counts = arrays(np.int32, st.tuples(*[st.integers(1, 6)] * 3), elements=st.integers(0, 9))
steps = st.tuples(*[st.integers(1, 4)] * 3)


@given(arrays_of_counts, steps)
def test_sums_of_blocks_are_those_of_their_voxels(values, step):
    sums = block_sums(values, step)
    for block in np.ndindex(sums.shape):
        part = tuple(slice(b * s, (b + 1) * s) for b, s in zip(block, step, strict=True))
        assert sums[block] == values[part].sum()


@given(arrays_of_counts, steps)
def test_refined_voxels_have_the_value_of_their_block(values, step):
    fine = refined(block_sums(values, step), step, values.shape)
    assert fine.shape == values.shape
    for index in np.ndindex(values.shape):
        block = tuple(i // s for i, s in zip(index, step, strict=True))
        assert fine[index] == block_sums(values, step)[block]


def test_blocks_are_at_least_a_voxel():
    assert coarse_step(np.array([0.6, 2.0, 5.0]), 2.0) == (3, 1, 1)
