"""Small trees of the made robot, each node given by how far its needles turn and reach."""

import numpy as np
from scipy.spatial.transform import Rotation

from catalog.yaml_file import load_mapping
from nodes.geometry.grids import LabelMap, Volume
from nodes.mechanics.crisp_edges import CrispEdges
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.planning.artefacts import CrispTree, CrispTrees
from nodes.planning.parameters import PlanCrispMotionsParameters
from tests.conftest import ROOT
from tests.nodes.planning.made_motions import ORIGIN, PLACED, turned

VALUES = load_mapping(ROOT / "catalog/parameters/plan_crisp_motions.yml")


def plan_parameters(**changed) -> PlanCrispMotionsParameters:
    """Cells of 4 needle radii are allowed, so that made grids stay small."""
    made = {"sheath_avoids": (), "coarsest_cell": 8.0}
    return PlanCrispMotionsParameters(**{**VALUES, **made, **changed})


def joints(tool=(0, 0, 0), snare=(0, 0, 0), longer=(0, 0)):
    """Return frames and lengths; turns in degrees from the start."""
    return turned(tool, snare), PLACED.start.lengths_mm + np.array(longer, float)


def grow(nodes, parents, seeing=(), placed=PLACED) -> CrispTree:
    """Return a tree with these nodes after the start; each is solved from its parent."""
    frames, lengths = map(np.array, zip(joints(), *nodes, strict=True))
    parents = np.array([-1, *parents])
    wrenches, poses = np.zeros((len(frames), 2, 6)), np.zeros((len(frames), 4, 4))
    for node, parent in enumerate(parents):
        before = max(parent, 0)
        edge = CrispEdges(
            frames[[before]], frames[[node]], lengths[[before]], lengths[[node]],
            wrenches[[before]], np.array([30 if node else 0]),
        )  # fmt: skip
        track = follow_crisp_edges(placed.setup, edge, plan_parameters())
        assert (track.status == 0).all()
        wrenches[node], poses[node] = track.wrenches[0, -1], track.patient_from_camera[0, -1]
    quaternions = Rotation.from_matrix(frames.reshape(-1, 3, 3)).as_quat(scalar_first=True)
    count = len(frames)
    return CrispTree(
        placed, parents, quaternions.reshape(count, 2, 4), lengths,
        np.full(count, 30), wrenches, poses[:, :3, 3], poses[:, :3, 2],
        np.arange(count) / 10, np.zeros(count, int), np.array(seeing, int), "node limit", (),
    )  # fmt: skip


def trees(*grown: CrispTree) -> CrispTrees:
    return CrispTrees(grown, ORIGIN)


def distances(grid: LabelMap) -> Volume:
    """Distances of the free cells' centres to the nearest box, by SciPy from the cells' faces."""
    from scipy import ndimage

    fine = np.repeat(np.repeat(np.repeat(grid.mask("free"), 3, 0), 3, 1), 3, 2)
    cell = float(grid.patient_from_index[0, 0])
    far = ndimage.distance_transform_edt(np.pad(fine, 1), sampling=cell / 3)[1:-1, 1:-1, 1:-1]
    half = cell / 6 * np.sqrt(3)
    least = np.maximum(far[1::3, 1::3, 1::3] - half, 0)
    return Volume(least.astype(np.float32), grid.patient_from_index, "mm", ORIGIN)
