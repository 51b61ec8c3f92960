"""A robot of two needles in a box of cells, and motions of it that are solved as planners may."""

import numpy as np
from scipy.spatial.transform import Rotation

from catalog.yaml_file import load_mapping
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.mechanics.materials import NITINOL
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, Snare
from nodes.mechanics.solve_crisp import solve_crisp
from nodes.planning.artefacts import CrispMotion, MotionPlan, PlacedSetup
from nodes.planning.parameters import CheckCrispPlansParameters
from tests.conftest import ROOT

PARAMETERS = CheckCrispPlansParameters(
    **load_mapping(ROOT / "catalog/parameters/check_crisp_plans.yml")
)
ORIGIN = Origin("a test")
CELL = 2.0  # mm
LOW, HIGH = np.array([-40.0, -30, 0]), np.array([60.0, 30, 120])  # corners of the free box
TOOL, SNARE = np.array([0.0, 0, 0]), np.array([60.0, 0, 60])  # entry points on its faces
NEEDLE = Needle(NITINOL, 0.84, 1.02, np.zeros(3))
SETUP = CrispSetup(
    (NEEDLE, NEEDLE), np.array([TOOL, SNARE]), (Snare(1, 10.0, "tip", "rigid"),), 80.0
)


def make_frames() -> np.ndarray:
    """Both needles at rest: the tool's d2 points against the snare [Kuntz2017] eq. (6)."""
    to_snare = np.array([1.0, 0, 0])
    up = np.array([0.0, 0, 1])
    tool = np.column_stack([np.cross(to_snare, up), to_snare, up])
    about = Rotation.from_rotvec(np.pi / 2 * np.array([-1.0, 0, 0])).as_matrix()
    return np.array([tool, tool @ about.T])


START = CrispConfiguration(make_frames(), np.array([70.0, 60.0]))
PLACED = PlacedSetup(
    "made", SETUP, START, START.patient_from_entry[:, :, 2], np.radians([40.0, 40.0]),
    np.array([30.0, 30.0]), np.array([120.0, 120.0]),
)  # fmt: skip


def box_grid(walls: tuple = (), cell: float = CELL) -> LabelMap:
    """Free cells between LOW and HIGH, and boxes of obstacles in them, two cells of wall around."""
    counts = np.rint((HIGH - LOW) / cell).astype(int)
    free = np.zeros(counts + 4, bool)
    free[2:-2, 2:-2, 2:-2] = True
    matrix = np.diag([cell, cell, cell, 1.0])
    matrix[:3, 3] = LOW - 1.5 * cell
    centres = [LOW[i] - 1.5 * cell + cell * np.arange(n) for i, n in enumerate(free.shape)]
    for low, high in walls:
        inside = [(c > a) & (c < b) for c, a, b in zip(centres, low, high, strict=True)]
        free[np.ix_(*inside)] = False
    voxels = np.where(free, 1, 0).astype(np.uint8)
    beside = np.zeros_like(free)
    for axis in range(3):
        for way in (1, -1):
            beside |= np.roll(free, way, axis)
    voxels[beside & ~free] = 2
    return LabelMap(voxels, matrix, ("free", "boundary"), ORIGIN)


def around(place: np.ndarray, low: tuple, high: tuple) -> tuple[np.ndarray, np.ndarray]:
    """The corners of a box about a place."""
    return place + np.array(low, float), place + np.array(high, float)


def bone_map(*boxes: tuple) -> LabelMap:
    """Bone in boxes of 1 mm voxels around the cavity; the other way round along x."""
    spacing, corner = np.array([-1.0, 1, 2]), np.array([120.0, -60, -60])
    voxels = np.zeros((200, 120, 100), np.uint8)
    centres = [corner[i] + spacing[i] * np.arange(n) for i, n in enumerate(voxels.shape)]
    for low, high in boxes:
        inside = [(c > a) & (c < b) for c, a, b in zip(centres, low, high, strict=True)]
        voxels[np.ix_(*inside)] = 1
    matrix = np.diag([*spacing, 1.0])
    matrix[:3, 3] = corner
    return LabelMap(voxels, matrix, ("bone",), ORIGIN)


def turned(tool: tuple, snare: tuple) -> np.ndarray:
    """The start's frames, turned by rotation vectors in degrees."""
    turns = Rotation.from_rotvec(np.radians([tool, snare], dtype=float)).as_matrix()
    return turns @ START.patient_from_entry


def solve_motion(frames: np.ndarray, lengths: np.ndarray, setup: CrispSetup = SETUP) -> CrispMotion:
    """Solve steps one after the other, each from the last."""
    wrenches, cameras, seed = [], [], None
    for turns, reach in zip(frames, lengths, strict=True):
        found = solve_crisp(setup, CrispConfiguration(turns, reach), PARAMETERS, seed)
        assert found.status == "solved", found.reason
        seed = found.base_wrenches
        wrenches.append(seed)
        cameras.append(found.patient_from_camera)
    return CrispMotion(frames, lengths, np.array(wrenches), np.array(cameras))


def move(tool=(0, 0, 0), snare=(0, 0, 0), longer=(0, 0), steps=6, setup=SETUP) -> CrispMotion:
    """Turn needles at their entry points and push them in, evenly."""
    shares = np.linspace(0, 1, steps)
    frames = np.array([turned(share * np.array(tool), share * np.array(snare)) for share in shares])
    lengths = START.lengths_mm + shares[:, None] * np.array(longer, float)
    return solve_motion(frames, lengths, setup)


def ahead(motion: CrispMotion, grid: LabelMap) -> np.ndarray:
    """The first cell that is not free along the camera's view at the end, by small steps."""
    pose = motion.patient_from_camera[-1]
    points = pose[:3, 3] + np.arange(0, 300, 0.01)[:, None] * pose[:3, 2]
    index = np.linalg.inv(grid.patient_from_index)
    cells = np.rint(points @ index[:3, :3].T + index[:3, 3]).astype(int)
    cells = np.clip(cells, 0, np.array(grid.voxels.shape) - 1)
    return cells[np.argmax(grid.voxels[tuple(cells.T)] != 1)][None]


def plan(motion: CrispMotion, cells: np.ndarray, placed: PlacedSetup = PLACED) -> MotionPlan:
    return MotionPlan("a place", np.zeros(3), cells, placed, "planned", "", motion, ())


GOOD = {"tool": (3, -4, 2), "snare": (2, 3, -1), "longer": (3, 2)}
