from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.reporting.artefacts import StageAccount
from nodes.reporting.pipeline_ranks import rank_stages


@st.composite
def pipelines(draw):
    """A random pipeline: each stage reads some of what stands before it."""
    stages, datasets = [], ["files", "setup"]
    for n in range(draw(st.integers(1, 9))):
        inputs = draw(st.lists(st.sampled_from(datasets), max_size=4, unique=True))
        outputs = [f"data_{n}_{k}" for k in range(draw(st.integers(0, 2)))]
        stages.append(
            StageAccount(
                f"stage_{n}", "", tuple(inputs), tuple(outputs), "computed", (), 1.0, "", ()
            )
        )
        datasets += outputs
    return tuple(stages)


@settings(max_examples=60, deadline=None)
@given(pipelines(), st.integers(1, 4))
def test_every_dataset_flows_downward_one_row_at_a_time(stages, columns):
    rows, nets = rank_stages(stages, columns)
    for net in nets:
        assert [node.row - net.nodes[0].row for node in net.nodes] == list(range(len(net.nodes)))
        for reader in net.readers:
            assert 0 <= reader.row - 1 - net.nodes[0].row < len(net.nodes)
    for at, row in enumerate(rows):
        assert all(node.row == at for node in row)


@settings(max_examples=60, deadline=None)
@given(pipelines(), st.integers(1, 4))
def test_every_stage_and_every_reading_is_there_once(stages, columns):
    rows, nets = rank_stages(stages, columns)
    names = [node.name for row in rows for node in row if node.kind == "stage"]
    assert sorted(names) == sorted(stage.name for stage in stages)
    shown = sorted((net.dataset, reader.name) for net in nets for reader in net.readers)
    assert shown == sorted((name, stage.name) for stage in stages for name in stage.inputs)


@settings(max_examples=60, deadline=None)
@given(pipelines(), st.integers(1, 4))
def test_no_row_holds_more_boxes_than_asked_for(stages, columns):
    rows, _ = rank_stages(stages, columns)
    assert max(sum(node.kind != "waypoint" for node in row) for row in rows) <= columns
