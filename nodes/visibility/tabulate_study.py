"""What set-ups see at equal time, with seeded and unseeded solves."""

from typing import TYPE_CHECKING

import numpy as np

from nodes.visibility.artefacts import VisibilitySets

if TYPE_CHECKING:
    import pandas

UNION = "union"


def tabulate_study(
    seeding_table: "pandas.DataFrame", visibility_sets: VisibilitySets
) -> "pandas.DataFrame":
    """Return the table of trees with the share of the surface that each sees, and their unions.

    Parameters
    ----------
    seeding_table : one row a tree: `name` (as the visibility set's), `setup`, `seeding`, and what
        it took to grow it.
    visibility_sets : of these trees.

    Returns
    -------
    The rows with `share_seen` after `seeding`; then, for each seeding, one row "union" of what its
    trees see together, its other numbers their sums (`seconds` their largest, as they are of equal
    time), `nodes_per_hour` left empty.
    """
    import pandas

    seen = {one.name: one.first_nodes >= 0 for one in visibility_sets.sets}
    table = seeding_table.copy()
    share = [float(seen[name].mean()) for name in table["name"]]
    table.insert(table.columns.get_loc("seeding") + 1, "share_seen", share)
    unions = [
        _unite(rows, np.any([seen[name] for name in rows["name"]], axis=0))
        for _, rows in table.groupby("seeding", sort=False)
    ]
    return pandas.concat([table, pandas.DataFrame(unions)], ignore_index=True)


def _unite(rows: "pandas.DataFrame", seen: np.ndarray) -> dict[str, object]:
    """Return the row of several trees together."""
    sums = rows.select_dtypes("number").sum().to_dict()
    return sums | {
        "name": UNION,
        "setup": UNION,
        "seeding": rows["seeding"].iloc[0],
        "share_seen": float(seen.mean()),
        "nodes_per_hour": np.nan,
        "seconds": rows["seconds"].max(),
    }
