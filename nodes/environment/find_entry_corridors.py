"""Where a straight needle can pass from the skin to the free space without touching bone."""

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from nodes.environment.distances import PARTS
from nodes.environment.entry_table import COLUMNS, Needles, list_entries
from nodes.environment.free_parts import boundary_of
from nodes.environment.needle_space import (
    OUTSIDE,
    WALL,
    NeedleSpace,
    cut_needle_space,
)
from nodes.environment.needle_starts import cone_directions, skin_points
from nodes.environment.needle_tips import tips_in_cells
from nodes.environment.parameters import FindEntryCorridorsParameters
from nodes.geometry.grids import LabelMap

if TYPE_CHECKING:
    import pandas

NAMES = ("entry", "corridor")
ENTRY, CORRIDOR = 1, 2
RUN_UP_CELLS = 3.0  # how far outside of the smoothed skin a needle starts, cells of the map

UNKNOWN = (
    "heart, great vessels, liver, diaphragm and rib cartilage are no labels: that a corridor"
    " avoids them is not checked, only the wall's thickness is limited"
)
NO_BONE = "no bone is labelled: no entry corridor can be called safe"
NO_WAY = "no straight needle can pass the wall under these limits"


def find_entry_corridors(
    label_map: LabelMap, occupancy_grid: LabelMap, parameters: FindEntryCorridorsParameters
) -> tuple[LabelMap, "pandas.DataFrame"]:
    """Find all straight ways through the chest wall that keep clear of bone.

    Points of the skin and directions in a cone about its inward normal are tried. A needle may pass
    if its axis goes from outside through nothing but wall labels, on at most the thickest wall,
    into S_free or another free part, goes on there for the tip's depth, and keeps the needle's
    radius and the margin from every voxel box of bone, of all other labels and of all other parts.
    The tip is in cells of that part; only on the first cell's diagonal behind the place where the
    labels become free may it be in boundary cells, as cells are free by halves.

    Parameters
    ----------
    label_map : anatomy, in which all inside the skin has a label.
    occupancy_grid : made from the label map; its "free" cells and further parts are to be reached.
    parameters : needle, margins, how finely is tried.

    Returns
    -------
    entry_map : on the label map's grid: "entry", the skin where a needle may go in, "corridor",
        the wall that a needle may pass; as fine as `skin_spacing_mm`.
    entry_table : one row an entry, first those with enough room beside them by the wall's
        thickness, then the others by room: `number`, `window` (openings through which needles reach
        connected places of one part; 1 has most needles), `part` (that is reached: "free" is where
        the robot moves), skin and pleura point and direction (patient LPS, mm),
        `wall_thickness_mm`, `bone_clearance_mm` (between the side of needle and tip and the nearest
        bone voxel; where bone is far, at least that), `tilt_deg` from the normal, `side` ("left",
        "right" of the body's middle), `face` ("front", "back", "side", "top", "bottom"). Empty,
        with notice, where there is no bone label or no opening.

    Raises
    ------
    BadInput where a wall label is unknown or the grids do not belong together.
    """
    voxels = np.zeros(label_map.voxels.shape, np.uint8)
    origin = label_map.origin.with_notice(UNKNOWN)
    found, any_bone = [], False
    for part in occupancy_grid.names:
        if part == "boundary":
            continue
        space = cut_needle_space(label_map, occupancy_grid, part, parameters)
        needles = _admissible(space, parameters) if space.bone.any() else None
        any_bone |= needles is not None
        if needles is not None and len(needles.skin):
            found.append((needles, space))
            _mark(voxels[space.box], _draw(needles, space, parameters))
    if not found:
        missing = NO_WAY if any_bone else NO_BONE
        origin = origin.with_notice(missing)
        return LabelMap(voxels, label_map.patient_from_index, NAMES, origin), _empty_table()
    if len(found) > 1:
        origin = origin.with_notice(f"entries lead into {len(found)} separate parts of the free"
                                    ' space; the robot moves in the one named "free"')  # fmt: skip
    table = list_entries(_number_windows(found), parameters)
    return LabelMap(voxels, label_map.patient_from_index, NAMES, origin), table


def _mark(voxels: UInt8[np.ndarray, "i j k"], drawn: UInt8[np.ndarray, "i j k"]) -> None:
    """Add what is drawn for one part; where another part has a corridor, an entry is shown."""
    voxels[drawn == ENTRY] = ENTRY
    voxels[(drawn == CORRIDOR) & (voxels == 0)] = CORRIDOR


def _empty_table() -> "pandas.DataFrame":
    import pandas

    whole, words = ("number", "window"), ("part", "side", "face")
    types = {c: int if c in whole else str if c in words else float for c in COLUMNS}
    return pandas.DataFrame({c: pandas.Series(dtype=t) for c, t in types.items()})


def _admissible(space: NeedleSpace, parameters: FindEntryCorridorsParameters) -> Needles:
    """Try all needles and return those that may pass."""
    skin, inward = skin_points(space.kinds != OUTSIDE, space.spacing, parameters.skin_spacing_mm)
    directions = cone_directions(inward, parameters.largest_tilt_deg, parameters.tilt_step_deg)
    run_up = RUN_UP_CELLS * parameters.skin_spacing_mm
    starts = skin[:, None] - run_up * directions
    ways, nearest = _trace(starts, directions, space, parameters)
    point, way = np.nonzero(~np.isnan(ways[..., 1]))
    reached = starts[point, way] + ways[point, way, 1][:, None] * directions[point, way]
    kept = tips_in_cells(reached, directions[point, way], space, parameters.tip_depth_mm)
    point, way, reached = point[kept], way[kept], reached[kept]
    start, direction = starts[point, way], directions[point, way]
    return Needles(
        skin=start + ways[point, way, 0][:, None] * direction,
        pleura=reached,
        direction=direction,
        normal=inward[point],
        nearest=nearest[point, way],
        window=_windows(reached, parameters.skin_spacing_mm),
    )


def _trace(
    starts: Float[np.ndarray, "n d 3"],
    directions: Float[np.ndarray, "n d 3"],
    space: NeedleSpace,
    parameters: FindEntryCorridorsParameters,
) -> tuple[Float[np.ndarray, "n d 2"], Float[np.ndarray, "n d"]]:
    """Return the ways to skin and free space, nan where a needle may not pass, and how near it
    comes to forbidden voxels."""
    from nodes.kernels.needle_rays import NeedleRules, trace_needles

    rules = NeedleRules(
        clearance=parameters.needle_radius_mm + parameters.margin_mm,
        thickest_wall=parameters.thickest_wall_mm,
        depth=parameters.tip_depth_mm,
        step=parameters.step_mm,
        run_up=2 * RUN_UP_CELLS * parameters.skin_spacing_mm,
    )
    ways, nearest = np.empty((*starts.shape[:2], 2)), np.empty(starts.shape[:2])
    shares = [np.array_split(array, PARTS) for array in (starts, directions, ways, nearest)]
    with ThreadPoolExecutor(PARTS) as pool:
        work = [
            pool.submit(
                trace_needles, s, d, space.kinds, space.distance, space.spacing, rules, w, n
            )
            for s, d, w, n in zip(*shares, strict=True)
        ]
        for done in work:
            done.result()
    return ways, nearest


def _windows(pleura: Float[np.ndarray, "n 3"], cell_mm: float) -> Int[np.ndarray, " n"]:
    """Number the openings: needles are of one where the cells that they reach hang together."""
    from scipy import ndimage

    if not len(pleura):
        return np.empty(0, int)
    cells = np.floor(pleura / cell_mm).astype(int)
    cells -= cells.min(axis=0)
    reached = np.zeros(cells.max(axis=0) + 1, bool)
    reached[tuple(cells.T)] = True
    parts, _ = ndimage.label(reached, np.ones((3, 3, 3), bool))
    return parts[tuple(cells.T)].astype(int)


def _number_windows(
    found: list[tuple[Needles, NeedleSpace]],
) -> list[tuple[Needles, NeedleSpace]]:
    """Number the openings of all parts together from 1, those with most needles first."""
    ends = np.cumsum([needles.window.max() for needles, _ in found])
    windows = [n.window - 1 + end - n.window.max() for (n, _), end in zip(found, ends, strict=True)]
    number = np.empty(ends[-1], int)
    number[np.argsort(-np.bincount(np.concatenate(windows)), kind="stable")] = np.arange(ends[-1])
    return [
        (needles._replace(window=number[window] + 1), space)
        for (needles, space), window in zip(found, windows, strict=True)
    ]


def _draw(
    needles: Needles, space: NeedleSpace, parameters: FindEntryCorridorsParameters
) -> UInt8[np.ndarray, "i j k"]:
    """Return the wall voxels in cells that needles cross, and the skin where they go in."""
    wall = space.kinds == WALL
    crossed = _in_cells(needles.skin, needles.pleura, space, parameters)
    labels = np.where(wall & crossed, CORRIDOR, 0).astype(np.uint8)
    skin = wall & boundary_of(space.kinds == OUTSIDE, "faces")
    labels[skin & _in_cells(needles.skin, needles.skin, space, parameters)] = ENTRY
    return labels


def _in_cells(
    starts: Float[np.ndarray, "n 3"],
    ends: Float[np.ndarray, "n 3"],
    space: NeedleSpace,
    parameters: FindEntryCorridorsParameters,
) -> Bool[np.ndarray, "i j k"]:
    """Return the voxels that a segment crosses, and all whose centres share a cell with theirs."""
    from nodes.kernels.needle_rays import mark_segments

    cell_mm = parameters.skin_spacing_mm
    places = [
        np.floor(np.arange(count) * step / cell_mm).astype(int)
        for count, step in zip(space.kinds.shape, space.spacing, strict=True)
    ]
    marked = np.zeros([int(place[-1]) + 1 for place in places], bool)
    mark_segments(starts, ends, space.spacing, parameters.step_mm, cell_mm, marked)
    return marked[np.ix_(*places)]
