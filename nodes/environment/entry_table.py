"""The entries that are listed: the best of their surroundings, with numbers for a surgeon."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from nodes.environment.needle_space import NeedleSpace
from nodes.environment.parameters import FindEntryCorridorsParameters
from nodes.geometry.frames import transform_points

if TYPE_CHECKING:
    import pandas

COLUMNS = ("number", "window", "part", "skin_x_mm", "skin_y_mm", "skin_z_mm", "pleura_x_mm",
           "pleura_y_mm", "pleura_z_mm", "direction_x", "direction_y", "direction_z",
           "wall_thickness_mm", "bone_clearance_mm", "tilt_deg", "side", "face")  # fmt: skip

DECIMALS = 4  # that count in comparing needles: the rest is noise, which must not order them


class Needles(NamedTuple):
    """Needles that may pass: mm and unit vectors along the grid's axes.

    skin, pleura : where each goes in, and where it reaches the free space.
    direction, normal : its direction, and the skin's inward normal.
    nearest : distance of its axis to forbidden voxels, mm, roughly.
    window : number of the opening that it passes, from 1.
    """

    skin: Float[np.ndarray, "n 3"]
    pleura: Float[np.ndarray, "n 3"]
    direction: Float[np.ndarray, "n 3"]
    normal: Float[np.ndarray, "n 3"]
    nearest: Float[np.ndarray, " n"]
    window: Int[np.ndarray, " n"]


def list_entries(
    found: list[tuple[Needles, NeedleSpace]], parameters: FindEntryCorridorsParameters
) -> "pandas.DataFrame":
    """Return one row for each chosen needle, the best first; each part chooses for itself."""
    import pandas

    table = pandas.concat([_rows(*one, parameters) for one in found], ignore_index=True)
    clearance, thickness = (
        table[name].to_numpy() for name in ("bone_clearance_mm", "wall_thickness_mm")
    )
    order = _best_first(clearance, thickness, parameters.enough_clearance_mm)
    table = table.iloc[order].reset_index(drop=True)
    table["number"] = np.arange(1, len(table) + 1)
    return table


def _rows(
    needles: Needles, space: NeedleSpace, parameters: FindEntryCorridorsParameters
) -> "pandas.DataFrame":
    import pandas

    chosen = _spaced(needles, parameters)
    tips = needles.pleura + parameters.tip_depth_mm * needles.direction
    clearance = np.array([
        _bone_clearance(needles.skin[n], tips[n], space, parameters.thickest_wall_mm)
        for n in chosen
    ]) - parameters.needle_radius_mm  # fmt: skip
    turn = space.patient_from_grid[:3, :3].T
    skin = transform_points(space.patient_from_grid, needles.skin[chosen])
    pleura = transform_points(space.patient_from_grid, needles.pleura[chosen])
    normal = needles.normal[chosen] @ turn
    cosine = np.einsum("ni,ni->n", needles.direction[chosen], needles.normal[chosen])
    columns = (
        np.zeros(len(chosen), int), needles.window[chosen], [space.part] * len(chosen), *skin.T,
        *pleura.T, *(needles.direction[chosen] @ turn).T, np.linalg.norm(pleura - skin, axis=1),
        clearance, np.degrees(np.arccos(np.clip(cosine, -1, 1))),
        np.where(skin[:, 0] > space.middle[0], "left", "right").astype(str), _faces(normal),
    )  # fmt: skip
    return pandas.DataFrame(dict(zip(COLUMNS, columns, strict=True)))


def _best_first(
    clearance: Float[np.ndarray, " n"], thickness: Float[np.ndarray, " n"], enough_mm: float
) -> Int[np.ndarray, " n"]:
    """Return the order from much room beside the needle to little; where there is enough, the
    thinner wall comes first, since far from all bone lie the belly and the neck."""
    room = np.minimum(clearance, enough_mm)
    return np.lexsort((thickness.round(DECIMALS), -room.round(DECIMALS)))


def _spaced(needles: Needles, parameters: FindEntryCorridorsParameters) -> Int[np.ndarray, " m"]:
    """Return the best needles whose entries keep a distance from each other's, the best first."""
    from scipy.spatial import cKDTree

    thickness = np.linalg.norm(needles.pleura - needles.skin, axis=1)
    clearance = needles.nearest - parameters.needle_radius_mm
    order = _best_first(clearance, thickness, parameters.enough_clearance_mm)
    tree = cKDTree(needles.skin)
    left, chosen = np.ones(len(order), bool), []
    for n in order:
        if left[n]:
            chosen.append(int(n))
            left[tree.query_ball_point(needles.skin[n], parameters.candidate_spacing_mm)] = False
    return np.array(chosen, int)


def _bone_clearance(
    skin: Float[np.ndarray, "3"], tip: Float[np.ndarray, "3"], space: NeedleSpace, most_mm: float
) -> float:
    """Return the exact distance of a needle's axis, from skin to tip, to the nearest bone voxel's
    box, or `most_mm` where there is none within that."""
    from nodes.kernels.needle_rays import segment_clearance

    reach, clearance = 5.0, np.inf
    while clearance > reach and reach < most_mm:
        reach = min(2 * reach, most_mm)
        low = np.floor((np.minimum(skin, tip) - reach) / space.spacing).astype(int)
        high = np.ceil((np.maximum(skin, tip) + reach) / space.spacing).astype(int) + 1
        box = tuple(slice(max(a, 0), max(b, 0)) for a, b in zip(low, high, strict=True))
        bone = (np.argwhere(space.bone[box]) + np.maximum(low, 0)) * space.spacing
        clearance = segment_clearance(skin, tip, bone, space.spacing / 2)
    return float(min(clearance, most_mm))


def _faces(inward: Float[np.ndarray, "n 3"]) -> np.ndarray:
    """Return which face of the body each inward normal belongs to, patient LPS."""
    names = np.array(["side", "back", "front", "top", "bottom"])
    axis = np.argmax(abs(inward), axis=1)
    outward = -np.take_along_axis(inward, axis[:, None], axis=1)[:, 0] > 0
    place = np.select(
        [axis == 0, (axis == 1) & outward, axis == 1, (axis == 2) & outward], [0, 1, 2, 3], 4
    )
    return names[place]
