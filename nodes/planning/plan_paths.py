"""Ways through the configuration space: solved configurations, and pieces that replace others."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.arrays import freeze_arrays
from nodes.planning.artefacts import CrispTree

Turns = Float[np.ndarray, "n needle 3"]
Orientations = Float[np.ndarray, "n needle 3 3"]
Lengths = Float[np.ndarray, "n needle"]


@dataclass(frozen=True)
class Path:
    """Solved configurations in order; from one corner to the next, orientations turn at constant
    speed and lengths change evenly.

    Parameters
    ----------
    orientations : patient_from_entry.
    wrenches : moment, N mm, and force, N, at the entry points.
    corners : (corner,) places among the configurations, of the first, the last and some between.
    """

    orientations: Orientations
    lengths_mm: Lengths
    wrenches: Float[np.ndarray, "n needle 6"]
    corners: Int[np.ndarray, "corner"]

    def __post_init__(self) -> None:
        freeze_arrays(self)

    def until(self, last: int) -> "Path":
        """Return the way up to one of its places."""
        upto = slice(last + 1)
        corners = np.unique(np.minimum(self.corners, last))
        return Path(self.orientations[upto], self.lengths_mm[upto], self.wrenches[upto], corners)

    def replaced(self, first: int, last: int, piece: "Path") -> "Path":
        """Return the way with another one between two of its places, at which the piece begins and
        ends."""
        added = len(piece.lengths_mm) - (last - first + 1)
        before, after = self.corners[self.corners < first], self.corners[self.corners > last]
        return Path(
            _splice(self.orientations, first, last, piece.orientations),
            _splice(self.lengths_mm, first, last, piece.lengths_mm),
            _splice(self.wrenches, first, last, piece.wrenches),
            np.concatenate([before, first + piece.corners, after + added]),
        )


def _splice(values: np.ndarray, first: int, last: int, piece: np.ndarray) -> np.ndarray:
    """Return values with those between two places exchanged; the ends stay as they are."""
    return np.concatenate([values[: first + 1], piece[1:-1], values[last:]])


def trace_back(parents: Int[np.ndarray, "node"], node: int) -> Int[np.ndarray, "n"]:
    """Return the nodes that lead to one, the start first."""
    nodes = [node]
    while parents[nodes[-1]] >= 0:
        nodes.append(int(parents[nodes[-1]]))
    return np.array(nodes[::-1])


def read_nodes(tree: CrispTree, nodes: Int[np.ndarray, "n"]) -> Path:
    """Return nodes of a tree as a way of corners."""
    from scipy.spatial.transform import Rotation

    quaternions = tree.quaternions[nodes]
    turns = Rotation.from_quat(quaternions.reshape(-1, 4), scalar_first=True).as_matrix()
    return Path(
        turns.reshape(*quaternions.shape[:2], 3, 3),
        tree.lengths_mm[nodes],
        tree.wrenches[nodes],
        np.arange(len(nodes)),
    )


def turns_between(starts: Orientations, ends: Orientations) -> Turns:
    """Return the rotation vectors, rad in patient axes, that lead from one to the other."""
    from scipy.spatial.transform import Rotation

    apart = ends @ starts.swapaxes(-1, -2)
    return Rotation.from_matrix(apart.reshape(-1, 3, 3)).as_rotvec().reshape(apart.shape[:-1])


def way_lengths(
    starts: Orientations,
    ends: Orientations,
    start_lengths_mm: Lengths,
    end_lengths_mm: Lengths,
    lever_mm: float,
) -> Float[np.ndarray, "n"]:
    """Return the lengths of geodesics, mm: roots of the sums, over the needles, of the squares of
    turns times the lever and of changes of length."""
    turns = lever_mm * np.linalg.norm(turns_between(starts, ends), axis=-1)
    return np.sqrt(np.sum(turns**2 + (end_lengths_mm - start_lengths_mm) ** 2, axis=-1))


def places_along(path: Path, lever_mm: float) -> Float[np.ndarray, "n"]:
    """Return how far along a way its configurations are, mm, from 0 on."""
    orientations, lengths = path.orientations, path.lengths_mm
    steps = way_lengths(orientations[:-1], orientations[1:], lengths[:-1], lengths[1:], lever_mm)
    return np.concatenate([[0.0], np.cumsum(steps)])
