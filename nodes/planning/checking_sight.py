"""Whether the camera sees cells: the line to each centre against the boxes of occupied cells."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.planning.checking_boxes import Boxes

GRAZE = 1e-9  # share of a line within a box that counts as touching it alone
PARALLEL = 1e-300  # mm; a line along a face is cut by that face's planes infinitely far away


def see_cells(
    patient_from_camera: Float[np.ndarray, "4 4"],
    field_of_view_deg: float,
    cells: Int[np.ndarray, "cell 3"],
    boxes: Boxes,
) -> Bool[np.ndarray, "cell"]:
    """Return which cells lie within the camera's cone with nothing before their centres."""
    to_grid = boxes.grid_from_patient
    camera = to_grid[:3, :3] @ patient_from_camera[:3, 3] + to_grid[:3, 3]
    view = to_grid[:3, :3] @ patient_from_camera[:3, 2]
    targets = cells * (2 * boxes.half)
    ways = targets - camera
    across = np.linalg.norm(np.cross(ways, view), axis=1)
    seen = np.arctan2(across, ways @ view) <= np.radians(field_of_view_deg) / 2
    for cell in np.flatnonzero(seen):
        seen[cell] = not _is_blocked(camera, targets[cell], boxes)
    return seen


def are_on_surface(cells: Int[np.ndarray, "cell 3"], boxes: Boxes) -> bool:
    """Return whether all cells are occupied ones next to others, by a corner at least."""
    if not len(boxes.centres):
        return not len(cells)
    away, _ = boxes.tree.query(cells * (2 * boxes.half))
    return bool((away < boxes.half.min()).all())


def _is_blocked(
    camera: Float[np.ndarray, "3"], target: Float[np.ndarray, "3"], boxes: Boxes
) -> bool:
    """Return whether a line cuts an occupied box before the target's own (slabs [Kay1986])."""
    low, high = np.minimum(camera, target) - boxes.half, np.maximum(camera, target) + boxes.half
    near = ((boxes.centres >= low) & (boxes.centres <= high)).all(axis=1)
    centres = boxes.centres[near & (abs(boxes.centres - target) > boxes.half).any(axis=1)]
    way = target - camera
    way = np.where(abs(way) < PARALLEL, PARALLEL, way)
    one, other = (centres - boxes.half - camera) / way, (centres + boxes.half - camera) / way
    enter = np.minimum(one, other).max(axis=1, initial=0.0)
    leave = np.maximum(one, other).min(axis=1, initial=1.0)
    return bool((leave - enter > GRAZE).any())
