"""The study's table adds what is seen, and what set-ups see together."""

import numpy as np
import pandas as pd
import pytest

from nodes.geometry.origin import Origin
from nodes.visibility.artefacts import VisibilitySet, VisibilitySets
from nodes.visibility.tabulate_study import tabulate_study


def test_the_union_counts_a_cell_once() -> None:
    seen = {"1 p": [0, -1, 3, -1], "2 p": [5, 5, -1, -1], "1 z": [0, -1, -1, -1]}
    cells = np.zeros((4, 3), int)
    sets = tuple(VisibilitySet(n, np.array(f), np.zeros(6)) for n, f in seen.items())
    visible = VisibilitySets(cells, np.eye(4), (2, 2, 2), "own ray", sets, Origin("made"))
    table = pd.DataFrame(
        {
            "name": list(seen), "setup": ["1", "2", "1"], "seeding": ["parent", "parent", "zero"],
            "nodes": [6, 7, 2], "nodes_per_hour": [60.0, 70.0, 20.0], "seconds": [1.0, 1.1, 1.0],
        }
    )  # fmt: skip
    study = tabulate_study(table, visible)
    assert study["share_seen"].tolist() == pytest.approx([0.5, 0.5, 0.25, 0.75, 0.25])
    unions = study[study["setup"] == "union"]
    assert unions["nodes"].tolist() == [13, 2]
    assert unions["seconds"].tolist() == [1.1, 1.0]
    assert unions["nodes_per_hour"].isna().all()
