"""Stages in rows, so that every dataset flows downward [Sugiyama1981].

Sugiyama, Tagawa, Toda 1981, Methods for visual understanding of hierarchical system structures,
IEEE Trans. SMC 11(2): rows by longest path, waypoints where an arrow passes a row, and an order
within each row by the mean place of the neighbours.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from statistics import fmean

from nodes.reporting.artefacts import StageAccount

SWEEPS = 4
"""Times that the rows are ordered, down and up; pictures of 30 stages stop changing before."""


@dataclass(eq=False)
class Node:
    """A thing that takes room in a row: a stage, an input, or the waypoint of a passing arrow."""

    name: str
    kind: str
    row: int
    above: list["Node"] = field(default_factory=list)
    below: list["Node"] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Net:
    """One dataset: from its source (None where nothing shown makes it) along its waypoints to all
    that read it."""

    dataset: str
    nodes: tuple[Node, ...]
    readers: tuple[Node, ...]


def rank_stages(
    stages: tuple[StageAccount, ...], columns: int
) -> tuple[list[list[Node]], tuple[Net, ...]]:
    """Return rows of nodes and the datasets that run between them.

    Parameters
    ----------
    stages : in the order of the pipeline, makers before readers.
    columns : most stages and inputs in one row; a longer row goes on in the next.
    """
    ranks = wrap_ranks(find_ranks(stages), columns)
    nodes = {name: Node(name, kind_of(name, stages), row) for name, row in ranks.items()}
    rows: list[list[Node]] = [[] for _ in range(max(ranks.values(), default=-1) + 1)]
    for node in nodes.values():
        rows[node.row].append(node)
    nets = tuple(
        run_net(dataset, nodes[source], [nodes[name] for name in readers], rows)
        for dataset, (source, readers) in find_datasets(stages).items()
    )
    order_rows(rows)
    return rows, nets


def kind_of(name: str, stages: tuple[StageAccount, ...]) -> str:
    """Return "stage" or "input"."""
    return "stage" if any(stage.name == name for stage in stages) else "input"


def find_datasets(
    stages: tuple[StageAccount, ...],
) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return for each dataset its source and its readers; an input is its own source."""
    source = {output: stage.name for stage in stages for output in stage.outputs}
    inputs = [name for stage in stages for name in stage.inputs if name not in source]
    names = dict.fromkeys([*inputs, *source])
    return {
        name: (
            source.get(name, name),
            tuple(stage.name for stage in stages if name in stage.inputs),
        )
        for name in names
    }


def find_ranks(stages: tuple[StageAccount, ...]) -> dict[str, int]:
    """Return the row of each stage and input: one below the lowest that it reads from.

    An input stands right above its first reader.
    """
    source = {output: stage.name for stage in stages for output in stage.outputs}
    ranks: dict[str, int] = {}
    for stage in stages:
        above = [ranks.get(source.get(name, ""), 0) for name in stage.inputs]
        ranks[stage.name] = 1 + max(above, default=0)
    for stage in reversed(stages):
        for name in stage.inputs:
            if name not in source:
                ranks[name] = min(ranks.get(name, ranks[stage.name]), ranks[stage.name] - 1)
    return ranks


def wrap_ranks(ranks: dict[str, int], columns: int) -> dict[str, int]:
    """Return rows with at most `columns` members each; nothing in one rank reads from another."""
    rows: dict[str, int] = {}
    row = 0
    for rank in sorted(set(ranks.values())):
        members = [name for name in ranks if ranks[name] == rank]
        for start in range(0, len(members), columns):
            rows |= dict.fromkeys(members[start : start + columns], row)
            row += 1
    return rows


def run_net(dataset: str, source: Node, readers: list[Node], rows: list[list[Node]]) -> Net:
    """Lay one dataset from its source to its readers, with a waypoint in every row it passes."""
    chain = [source]
    for row in range(source.row + 1, max((reader.row for reader in readers), default=0)):
        waypoint = Node(dataset, "waypoint", row)
        rows[row].append(waypoint)
        chain.append(waypoint)
    for upper, lower in pairwise(chain):
        connect(upper, lower)
    for reader in readers:
        connect(chain[reader.row - source.row - 1], reader)
    return Net(dataset, tuple(chain), tuple(readers))


def connect(upper: Node, lower: Node) -> None:
    """Make two nodes of neighbouring rows know each other."""
    upper.below.append(lower)
    lower.above.append(upper)


def order_rows(rows: list[list[Node]]) -> None:
    """Sort each row by the mean place of its neighbours, downward and upward in turn."""
    for _ in range(SWEEPS):
        for row in rows[1:]:
            sort_row(row, "above", rows)
        for row in reversed(rows[:-1]):
            sort_row(row, "below", rows)


def sort_row(row: list[Node], side: str, rows: list[list[Node]]) -> None:
    """Sort one row; a node without neighbours on that side keeps its place."""
    place = {
        id(node): (at + 0.5) / len(members) for members in rows for at, node in enumerate(members)
    }

    def mean_place(node: Node) -> float:
        neighbours = node.above if side == "above" else node.below
        return fmean(place[id(other)] for other in neighbours) if neighbours else place[id(node)]

    row.sort(key=mean_place)
