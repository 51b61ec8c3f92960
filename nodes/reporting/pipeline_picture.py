"""The picture of a run: stages as boxes, datasets as arrows."""

from dataclasses import dataclass, replace

from nodes.reporting.artefacts import StageAccount
from nodes.reporting.pipeline_ranks import Net, Node, rank_stages
from nodes.reporting.rendering import render_template

BOX_HEIGHT, WAYPOINT_WIDTH, GAP, MARGIN = 46.0, 4.0, 14.0, 6.0
LABEL_LINE, ROOM_FOR_ARROWS = 14.0, 34.0
RELAXATIONS = 12
STATUS_WORDS = {"computed": "computed", "cached": "from cache", "running": "this page"}


@dataclass(frozen=True)
class Place:
    """Middle and size of a node, in pixels of the picture."""

    x: float
    y: float
    width: float


def draw_pipeline(
    stages: tuple[StageAccount, ...],
    inputs: tuple[str, ...],
    columns: int,
    box_width: float,
    name: str,
) -> str:
    """Return an inline SVG of the stages in rows.

    Parameters
    ----------
    stages : in the order of the pipeline.
    inputs : names of the datasets that a person gave; what no stage made besides is not drawn.
    columns : most boxes in a row.
    box_width : width of a box in pixels; about 7.2 a letter of the longest name.
    name : what tells this picture's parts from another's on the same page.
    """
    rows, nets = rank_stages(keep_drawn(stages, inputs), columns)
    tops, height = place_rows(rows, nets)
    across, width = place_across(rows, box_width)
    places = {
        id(node): Place(
            across[id(node)], tops[node.row] + BOX_HEIGHT / 2, width_of(node, box_width)
        )
        for row in rows
        for node in row
    }
    values = {
        "name": name,
        "width": width,
        "height": height,
        "boxes": draw_boxes(rows, places, stages),
        "arrows": [path for net in nets for path in draw_net(net, nets, places)],
        "labels": [draw_label(net, nets, places) for net in nets if net.nodes[0].kind == "stage"],
        "box_height": BOX_HEIGHT,
    }
    return render_template("pipeline.svg", values)


def keep_drawn(
    stages: tuple[StageAccount, ...], inputs: tuple[str, ...]
) -> tuple[StageAccount, ...]:
    """Return the stages without the inputs that neither a person nor a stage made."""
    drawn = {*inputs, *(output for stage in stages for output in stage.outputs)}
    return tuple(
        replace(stage, inputs=tuple(name for name in stage.inputs if name in drawn))
        for stage in stages
    )


def width_of(node: Node, box_width: float) -> float:
    """Return the room that a node takes in its row."""
    return WAYPOINT_WIDTH if node.kind == "waypoint" else box_width


def place_rows(rows: list[list[Node]], nets: tuple[Net, ...]) -> tuple[list[float], float]:
    """Return the top of each row and the height of all; below a row is room for its datasets."""
    tops, top = [], MARGIN
    for row in rows:
        tops.append(top)
        lines = max((len(outputs_of(node, nets)) for node in row), default=0)
        top += BOX_HEIGHT + lines * LABEL_LINE + ROOM_FOR_ARROWS
    return tops, top - ROOM_FOR_ARROWS + MARGIN + LABEL_LINE


def outputs_of(node: Node, nets: tuple[Net, ...]) -> list[Net]:
    """Return the datasets that a stage makes (an input is its own dataset and needs no label)."""
    return [net for net in nets if net.nodes[0] is node and node.kind == "stage"]


def place_across(rows: list[list[Node]], box_width: float) -> tuple[dict[int, float], float]:
    """Return the middle of each node and the width of the picture.

    Each node is drawn towards the mean of its neighbours, as far as its row has room.
    """
    room = max((row_width(row, box_width) for row in rows), default=0.0)
    middle: dict[int, float] = {}
    for row in rows:
        settle(row, [room / 2] * len(row), middle, box_width, room)
    for _ in range(RELAXATIONS):
        for row in rows:
            wishes = [wish_of(node, middle) for node in row]
            settle(row, wishes, middle, box_width, room)
    return {node: MARGIN + x for node, x in middle.items()}, room + 2 * MARGIN


def row_width(row: list[Node], box_width: float) -> float:
    """Return the least width of a row."""
    return sum(width_of(node, box_width) + GAP for node in row) - GAP


def wish_of(node: Node, middle: dict[int, float]) -> float:
    """Return the mean place of a node's neighbours, or its own where it has none."""
    neighbours = [middle[id(other)] for other in (*node.above, *node.below)]
    return sum(neighbours) / len(neighbours) if neighbours else middle[id(node)]


def settle(
    row: list[Node],
    wishes: list[float],
    middle: dict[int, float],
    box_width: float,
    room: float,
) -> None:
    """Place a row near its wishes, in order, without overlap and within the picture."""
    least, edge = [], 0.0
    for node, wish in zip(row, wishes, strict=True):
        half = width_of(node, box_width) / 2
        least.append(max(edge + half, wish))
        edge = least[-1] + half + GAP
    edge = room
    for node, x in zip(reversed(row), reversed(least), strict=True):
        half = width_of(node, box_width) / 2
        middle[id(node)] = min(edge - half, x)
        edge = middle[id(node)] - half - GAP


def draw_boxes(
    rows: list[list[Node]], places: dict[int, Place], stages: tuple[StageAccount, ...]
) -> list[dict[str, object]]:
    """Return what the template needs for each stage and input."""
    accounts = {stage.name: stage for stage in stages}
    return [
        {
            "kind": node.kind,
            "name": node.name,
            "place": places[id(node)],
            "account": accounts.get(node.name),
            "word": STATUS_WORDS.get(accounts[node.name].status, accounts[node.name].status)
            if node.name in accounts
            else "input",
        }
        for row in rows
        for node in row
        if node.kind != "waypoint"
    ]


def port_of(net: Net, nets: tuple[Net, ...], places: dict[int, Place]) -> tuple[float, float]:
    """Return where a dataset leaves its box; several share the lower edge."""
    source = net.nodes[0]
    place = places[id(source)]
    outputs = outputs_of(source, nets) or [net]
    share = (outputs.index(net) + 1) / (len(outputs) + 1)
    return place.x + (share - 0.5) * place.width, place.y + BOX_HEIGHT / 2


def draw_net(net: Net, nets: tuple[Net, ...], places: dict[int, Place]) -> list[dict[str, object]]:
    """Return one arrow from a dataset's name to each reader, along waypoints that they share."""
    x, y = port_of(net, nets, places)
    ends, ways = [(x, y + label_room(net, nets))], [""]
    for waypoint in net.nodes[1:]:
        place = places[id(waypoint)]
        top, bottom = place.y - BOX_HEIGHT / 2, place.y + BOX_HEIGHT / 2
        ways.append(f"{ways[-1]}{curve(*ends[-1], place.x, top)}V{bottom:.1f}")
        ends.append((place.x, bottom))
    arrows = []
    for reader in sorted(net.readers, key=lambda node: node.row):
        step = reader.row - net.nodes[0].row - 1
        target = (entry_of(net, reader, places), places[id(reader)].y - BOX_HEIGHT / 2 - 4)
        arrows.append({"d": ways[step] + curve(*ends[step], *target), "dataset": net.dataset})
        ways = [way.removeprefix(ways[step]) for way in ways]
    return arrows


def label_room(net: Net, nets: tuple[Net, ...]) -> float:
    """Return how far below its box a dataset's arrow begins: below its name."""
    outputs = outputs_of(net.nodes[0], nets)
    return LABEL_LINE * (outputs.index(net) + 1) + 2 if net in outputs else 0.0


def entry_of(net: Net, reader: Node, places: dict[int, Place]) -> float:
    """Return where on the upper edge of its reader a dataset arrives: in order, left to right."""
    arrivals = sorted(reader.above, key=lambda node: places[id(node)].x)
    before = net.nodes[reader.row - net.nodes[0].row - 1]
    share = (arrivals.index(before) + 1) / (len(arrivals) + 1)
    return places[id(reader)].x + (share - 0.5) * places[id(reader)].width


def curve(x: float, y: float, to_x: float, to_y: float) -> str:
    """Return a smooth path that leaves and arrives vertically."""
    bend = (to_y - y) / 2
    end = f"{to_x:.1f} {to_y - bend:.1f} {to_x:.1f} {to_y:.1f}"
    return f"M{x:.1f} {y:.1f}C{x:.1f} {y + bend:.1f} {end}"


def draw_label(net: Net, nets: tuple[Net, ...], places: dict[int, Place]) -> dict[str, object]:
    """Return a dataset's name and where it stands: each on a line of its own below the box."""
    x, y = port_of(net, nets, places)
    return {"x": x, "y": y + label_room(net, nets) - 4, "text": net.dataset}
