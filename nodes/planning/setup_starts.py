"""Starts at which no needle is bent: straight tools that straight snares meet at right angles.

From its entry point A the tool goes straight along t; a snare from B meets it at the foot of the
perpendicular, s = (B - A) . t, so that nothing is bent, whatever the joint. Where it is rigid,
[Kuntz2017] eq. (6) leaves but one roll of both needles: with the snare's tangent u, the tool's axes
are t x u, -u, t, and the snare's t x u, t, u.
"""

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from nodes.errors import BadInput

if TYPE_CHECKING:
    import pandas

    from nodes.kernels.crisp_collision import Rules, Space

FREE = "free"
PARTS = 4  # pieces of work that threads share; the result is the same for any number
Points = Float[np.ndarray, "n 3"]


class Entries(NamedTuple):
    """Rows of the table of entries that lead into the free space.

    numbers : as the table has them.
    points : (n, 3) where each needle reaches the free space, patient LPS mm.
    axes : (n, 3) unit vectors along each needle.
    """

    numbers: np.ndarray
    points: np.ndarray
    axes: np.ndarray


class Limits(NamedTuple):
    """What starts keep to.

    tilt_rad : largest angle between a needle and the axis of its entry.
    shortest_mm, longest_mm : of needles beyond their entry points.
    spacing_mm : least distance between entry points.
    """

    tilt_rad: float
    shortest_mm: float
    longest_mm: float
    spacing_mm: float


class Starts(NamedTuple):
    """Unbent starts of a tool and one snare.

    tools, snares : (n,) places in Entries.
    tangents, snare_tangents : (n, 3) unit vectors, patient axes.
    feet_mm, reaches_mm : (n,) where the joint is on the tool, and how long the snare is.
    """

    tools: np.ndarray
    snares: np.ndarray
    tangents: np.ndarray
    snare_tangents: np.ndarray
    feet_mm: np.ndarray
    reaches_mm: np.ndarray

    def take(self, rows: np.ndarray) -> "Starts":
        return Starts(*(column[rows] for column in self))


def read_entries(table: "pandas.DataFrame", needles: int) -> Entries:
    """Return the usable entries of a table.

    Parameters
    ----------
    needles : as many entries must be there at least.

    Raises
    ------
    BadInput where there are too few, which says why.
    """
    rows = table[(table["part"] == FREE).to_numpy(bool)]
    if len(rows) < needles:
        raise _too_few(table, len(rows), needles)
    points, axes = (
        rows[[f"{name}_{axis}" for axis in ends]].to_numpy(float)
        for name, ends in (("pleura", ("x_mm", "y_mm", "z_mm")), ("direction", "xyz"))
    )
    axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    return Entries(rows["number"].to_numpy(int), points, axes)


def _too_few(table: "pandas.DataFrame", usable: int, needles: int) -> BadInput:
    if not len(table):
        return BadInput(
            "the table of entries is empty",
            f"a set-up of {needles} needles has an entry for each",
            "see what the map of entries notices: without a bone label no entry is listed; else"
            " lower margin_mm or raise thickest_wall_mm of find_entry_corridors, or hand in"
            " set-ups",
        )
    others = sorted(set(table["part"]) - {FREE})
    elsewhere = f"; {len(table) - usable} lead into {' and '.join(others)}" if others else ""
    return BadInput(
        f"{usable} of {len(table)} entries lead into the free space in which the robot"
        f" moves{elsewhere}",
        f"a set-up of {needles} needles has an entry for each",
        "lower candidate_spacing_mm or margin_mm of find_entry_corridors; or choose another part of"
        " the free space by inside_patient_mm of its grid",
    )


def spread_tangents(axes: Points, tilt_rad: float, count: int) -> Float[np.ndarray, "n d 3"]:
    """Return directions evenly spread in a cone about each axis, the axis nearest to the first.

    A spiral by the golden angle [Vogel1979], each direction with an equal share of the cone.
    """
    place = (np.arange(count) + 0.5) / count
    z = 1 - place * (1 - np.cos(tilt_rad))
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    radius = np.sqrt(1 - z * z)
    cone = np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)
    helper = np.where(abs(axes[:, 2:]) > 0.9, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    first = np.cross(axes, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    frames = np.stack([first, np.cross(axes, first), axes], axis=1)
    return np.einsum("dl,nlx->ndx", cone, frames)


def lay_starts(
    entries: Entries,
    tangents: Float[np.ndarray, "n d 3"],
    longest_grasp_mm: float,
    limits: Limits,
) -> Starts:
    """Return all unbent starts within the limits, those of one tool and snare together.

    Parameters
    ----------
    tangents : (entry, direction, 3) that the tool may have at each entry.
    longest_grasp_mm : of the tool beyond the joint.
    """
    found = [
        _starts_of(tool, entries, tangents[tool], longest_grasp_mm, limits)
        for tool in range(len(entries.points))
    ]
    return Starts(*(np.concatenate(columns) for columns in zip(*found, strict=True)))


def _starts_of(
    tool: int, entries: Entries, tangents: Points, grasp_mm: float, limits: Limits
) -> Starts:
    ways = entries.points - entries.points[tool]
    feet = ways @ tangents.T
    across = feet[..., None] * tangents - ways[:, None]
    reaches = np.linalg.norm(across, axis=-1)
    sides = across / np.maximum(reaches, np.finfo(float).tiny)[..., None]
    tilted = np.einsum("nda,na->nd", sides, entries.axes) >= np.cos(limits.tilt_rad)
    apart = np.linalg.norm(ways, axis=1) >= limits.spacing_mm
    fits = tilted & apart[:, None] & (np.minimum(feet, reaches) >= limits.shortest_mm)
    fits &= (reaches <= limits.longest_mm) & (feet + grasp_mm <= limits.longest_mm)
    snare, way = np.nonzero(fits)
    return Starts(
        np.full(len(snare), tool), snare, tangents[way], sides[snare, way],
        feet[snare, way], reaches[snare, way],
    )  # fmt: skip


def roll_needles(
    tangents: Points, snare_tangents: Points
) -> tuple[Float[np.ndarray, "n 3 3"], Float[np.ndarray, "n 3 3"]]:
    """Return patient_from_entry of tools and snares, rolled as a rigid joint wants them."""
    across = np.cross(tangents, snare_tangents)
    tools = np.stack([across, -snare_tangents, tangents], axis=-1)
    return tools, np.stack([across, tangents, snare_tangents], axis=-1)


def check_starts(
    entries: Entries,
    starts: Starts,
    grasp_mm: float,
    rules: "Rules",
    cavity: "Space",
    wall: "Space",
) -> Int[np.ndarray, " n"]:
    """Return what `step_is_free` says of each start, the work shared by threads.

    Parameters
    ----------
    grasp_mm : of the tool beyond the joint.
    rules, cavity, wall : as `step_is_free` takes them.
    """
    from nodes.kernels.crisp_collision import FEWEST_PIECES, check_robots

    share = np.arange(FEWEST_PIECES + 1)[:, None] / FEWEST_PIECES
    codes = np.empty(len(starts.tools), np.int64)

    def check(part: np.ndarray) -> None:
        own = starts.take(part)
        tools = _chain(entries.points[own.tools], own.tangents, own.feet_mm, share)
        tips = tools[:, -1:] + grasp_mm * own.tangents[:, None]
        snares = _chain(entries.points[own.snares], own.snare_tangents, own.reaches_mm, share)
        found = np.empty(len(part), np.int64)
        check_robots(
            np.concatenate([tools, tips], axis=1), snares[:, None],
            np.stack([own.tangents, own.snare_tangents], axis=1), rules, cavity, wall, found,
        )  # fmt: skip
        codes[part] = found

    with ThreadPoolExecutor(PARTS) as pool:
        list(pool.map(check, np.array_split(np.arange(len(codes)), PARTS)))
    return codes


def _chain(
    entries: Points, tangents: Points, lengths: Float[np.ndarray, " n"], share: np.ndarray
) -> Float[np.ndarray, "n p 3"]:
    """Return points evenly along straight needles."""
    return entries[:, None] + (lengths[:, None, None] * share) * tangents[:, None]
