import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.reporting.share_curves import choose_times, count_seen, render_shares
from tests.nodes.reporting import made_plans


@given(st.lists(st.one_of(st.none(), st.floats(0.001, 1000)), min_size=1, max_size=40))
def test_the_share_is_the_count_of_cells_seen_until_then(firsts):
    first = np.array([np.nan if one is None else one for one in firsts])
    times = np.geomspace(0.001, 1000, 17)
    for is_of_all in (True, False):
        cells = len(firsts) if is_of_all else max(sum(one is not None for one in firsts), 1)
        counted = [sum(one is not None and one <= time for one in firsts) for time in times]
        shares = count_seen(first, times, is_of_all)
        assert shares == pytest.approx(100 * np.array(counted) / cells, abs=1e-6)


def test_times_run_from_the_first_sight_to_the_last():
    times = choose_times([np.array([np.nan, 0.5, 2.0]), np.array([8.0, np.nan, 1.0])], 11)
    assert (times[0], times[-1], len(times)) == pytest.approx((0.5, 8.0, 11))
    assert not len(choose_times([np.full(3, np.nan)], 11))


def test_dashed_curves_are_of_all_cells_and_solid_ones_end_at_all_that_is_seen():
    html = render_shares(made_plans.make_sets("set-up 1", "set-up 2"), 50)
    whole, own = html.split("</figure>")[:2]
    assert whole.count('dashed" d="M') == 6 and own.count('solid" d="M') == 6  # curves and keys
    ends = re.findall(r'solid" d="[^"]*?([\d.]+)"/>\n', own)
    assert [float(end) for end in ends] == pytest.approx([12.0] * 3)


def test_the_union_is_a_curve_of_its_own_only_where_there_are_several():
    assert "union" in render_shares(made_plans.make_sets("one", "two"), 20)
    assert "union" not in render_shares(made_plans.make_sets("one"), 20)
    assert render_shares(made_plans.make_sets(), 20) == ""
