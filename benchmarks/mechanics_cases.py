"""Random robots of sane sizes in random configurations, for tests and the benchmark."""

import numpy as np

from nodes.mechanics.robots import (
    ConcentricTubeConfiguration,
    ConcentricTubeRobot,
    CrispConfiguration,
    CrispSetup,
    Material,
    Needle,
    PointLoad,
    Snare,
    Tube,
)

NITINOL = Material("Nitinol", 58000.0, 0.33, 0.08)
NEEDLE_NITINOL = Material("Nitinol", 50000.0, 0.33, 0.08)
TOOL_MM, SNARE_MM = (0.97, 1.27), (0.84, 1.02)  # inner and outer diameters

# Two robots of ordinary size: ID, OD, E, nu, straight, curved, curvature; innermost first.
DUO = ((0.8, 1.1, 58e3, 0.33, 100, 50, 1 / 40), (1.3, 1.7, 65e3, 0.33, 50, 35, 1 / 90))
TRIO = (
    (0.8, 1.05, 58e3, 0.33, 120, 45, 1 / 50),
    (1.2, 1.5, 65e3, 0.33, 70, 40, 1 / 90),
    (1.75, 2.15, 75e3, 0.3, 30, 30, 1 / 150),
)


def concentric_robot(tubes: tuple[tuple[float, ...], ...]) -> ConcentricTubeRobot:
    """Return a robot of rows as `DUO` and `TRIO` have them."""
    made = [
        Tube(Material("Nitinol", *row[2:4], 0.08), *map(float, row[:2] + row[4:])) for row in tubes
    ]
    return ConcentricTubeRobot(tuple(made), np.eye(4))


def random_concentric_robot(chance: np.random.Generator, count: int) -> ConcentricTubeRobot:
    """Return a robot of so many nested tubes, each longer than the one around it."""
    inner, straight, curved = chance.uniform(0.4, 0.8), chance.uniform(15, 50, count), []
    tubes: list[Tube] = []
    for number in range(count):
        outer = inner + 2 * chance.uniform(0.1, 0.2)
        curved.append(chance.uniform(20, 50))
        beyond = float(straight[: count - number].sum())
        curvature = chance.uniform(0.003, 0.02 if number else 0.025)
        tubes.append(Tube(NITINOL, inner, outer, beyond, curved[-1], curvature))
        inner = outer + 2 * chance.uniform(0.02, 0.08)
    return ConcentricTubeRobot(tuple(_longer_inside(tubes)), random_pose(chance))


def _longer_inside(tubes):
    """Lengthen the curved part of a tube that does not reach beyond the one around it."""
    kept = list(tubes)
    for number in reversed(range(len(kept) - 1)):
        tube, around = kept[number], kept[number + 1]
        curved = max(tube.curved_length_mm, around.length_mm + 2.0 - tube.straight_length_mm)
        kept[number] = Tube(
            tube.material,
            tube.inner_diameter_mm,
            tube.outer_diameter_mm,
            tube.straight_length_mm,
            curved,
            tube.curvature_per_mm,
        )
    return kept


def random_insertion(chance: np.random.Generator, robot: ConcentricTubeRobot) -> np.ndarray:
    """Return beta (tube,) mm that keep the order of the tubes' bases and of their tips."""
    lengths = [tube.length_mm for tube in robot.tubes]
    inward = [-chance.uniform(0, 0.9) * lengths[-1]]
    for inside, outside in zip(lengths[-2::-1], lengths[:0:-1], strict=True):
        inward.append(inward[-1] - chance.uniform(0, 1) * (inside - outside))
    return np.array(inward[::-1])


def random_concentric_configuration(
    chance: np.random.Generator, robot: ConcentricTubeRobot
) -> ConcentricTubeConfiguration:
    """Return rotations from the whole turn and a random insertion."""
    rotations = chance.uniform(-np.pi, np.pi, len(robot.tubes))
    return ConcentricTubeConfiguration(rotations, random_insertion(chance, robot))


def random_pose(chance: np.random.Generator) -> np.ndarray:
    """Return a (4, 4) rigid transform."""
    pose = np.eye(4)
    pose[:3, :3] = turn(chance.normal(size=3) * 2)
    pose[:3, 3] = chance.uniform(-100, 100, 3)
    return pose


def turn(vector: np.ndarray) -> np.ndarray:
    """Return the (3, 3) rotation by a rotation vector, rad."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


def _arc(pose: np.ndarray, length: float, bend: np.ndarray) -> np.ndarray:
    """Return the (4, 4) pose at the end of an arc that turns by `bend` (3,) in body axes."""
    beyond = np.eye(4)
    angle = np.linalg.norm(bend)
    beyond[:3, :3] = turn(bend)
    beyond[:3, 3] = 0, 0, length
    if angle > 0:
        away = np.cross(bend / angle, [0, 0, 1])
        beyond[:3, 3] = length / angle * (np.sin(angle) * np.eye(3)[2] + (1 - np.cos(angle)) * away)
    return pose @ beyond


def _bend(chance: np.random.Generator, most: float) -> np.ndarray:
    """Return a turn about a random axis across the needle, rad."""
    azimuth, angle = chance.uniform(0, 2 * np.pi), chance.uniform(0, most)
    return angle * np.array([np.cos(azimuth), np.sin(azimuth), 0])


def random_crisp(
    chance: np.random.Generator,
    joints: tuple[str, ...],
    loads: int = 0,
    precurved: bool = False,
    off_deg: float = 4.0,
) -> tuple[CrispSetup, CrispConfiguration]:
    """Return a robot that can be assembled: the tool and the snares that reach it are laid as arcs,
    then everything is turned a little where it enters.

    Parameters
    ----------
    joints : "rigid" or "relaxed" of each snare; rigid ones come from the same side, as the joint
        asks.
    loads : how many forces and moments are on the tool.
    precurved : whether the needles are curved when nothing bends them.
    off_deg : how far each needle is turned away from its arc at most, degrees.
    """
    pose, length = random_pose(chance), chance.uniform(140, 260)
    tool_bend = _bend(chance, 0.5)
    grasps = np.sort(chance.uniform(12, 0.5 * length, len(joints)))
    grasps += 12.0 * np.arange(len(joints))
    poses, lengths, snares = [pose], [length], []
    azimuth = chance.uniform(0, 2 * np.pi)
    for number, (joint, grasp) in enumerate(zip(joints, grasps, strict=True), 1):
        here = _arc(pose, length - grasp, tool_bend * (length - grasp) / length)
        cosine = chance.uniform(-0.2, 0.2) if joint == "relaxed" and chance.random() < 0.5 else 0.0
        around = azimuth + 2 * np.pi * (number + chance.uniform(-0.15, 0.15)) / max(len(joints), 2)
        end = here.copy()
        end[:3, :3] = here[:3, :3] @ _snare_frame(joint, around, cosine)
        reach = chance.uniform(100, 170)
        poses.append(end @ np.linalg.inv(_arc(np.eye(4), reach, _bend(chance, 0.4))))
        lengths.append(reach)
        snares.append(Snare(number, float(grasp), "tip", joint, cosine))
    frames = [turn(np.radians(_off(chance, off_deg))) @ pose[:3, :3] for pose in poses]
    setup = CrispSetup(
        tuple(_needle(chance, number, precurved) for number in range(len(poses))),
        np.array([pose[:3, 3] for pose in poses]),
        tuple(snares),
        70.0,
    )
    pulls = tuple(_load(chance, length) for _ in range(loads))
    return setup, CrispConfiguration(np.array(frames), np.array(lengths), pulls)


def _off(chance, most):
    return chance.uniform(-1, 1, 3) * most / np.sqrt(3)


def _snare_frame(joint: str, azimuth: float, cosine: float) -> np.ndarray:
    """Return the snare's frame at its tip in the tool's there; rigid: [Kuntz2017] eq. (6)."""
    if joint == "rigid":
        return np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    sine = np.sqrt(1 - cosine**2)
    tangent = np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine])
    side = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    return np.stack([side, np.cross(tangent, side), tangent], 1)


def _needle(chance: np.random.Generator, number: int, precurved: bool) -> Needle:
    curvature = chance.uniform(-1, 1, 3) * [0.003, 0.003, 0.0] if precurved else np.zeros(3)
    return Needle(NEEDLE_NITINOL, *(SNARE_MM if number else TOOL_MM), curvature)


def _load(chance: np.random.Generator, length: float) -> PointLoad:
    return PointLoad(
        chance.uniform(0.2, 0.95) * length, chance.normal(0, 0.08, 3), chance.normal(0, 1.5, 3)
    )


def walk(
    chance: np.random.Generator,
    configuration: CrispConfiguration,
    steps: int,
    room: tuple[float, float] = (8.0, 4.0),
) -> list[CrispConfiguration]:
    """Return configurations along edges, no number of which changes by more than 1 mm or 1 degree
    a step: the way from one random target to the next within so many degrees and mm of the first.
    """
    offsets = walk_offsets(chance, len(configuration.lengths_mm), steps, room)
    return [offset_configuration(configuration, offset) for offset in offsets]


def walk_offsets(chance, needles, steps, room=(8.0, 4.0)) -> np.ndarray:
    """Return (step, needle, 4) rotation vectors in degrees and lengths in mm, from the first."""
    limits = np.array([room[0] / np.sqrt(3)] * 3 + [room[1]])
    path = [np.zeros((needles, 4))]
    while len(path) < steps:
        way = chance.uniform(-1, 1, (needles, 4)) * limits - path[-1]
        largest = max(np.linalg.norm(way[:, :3], axis=1).max(), np.abs(way[:, 3]).max())
        count = int(np.ceil(largest))
        path += [path[-1] + way * number / count for number in range(1, count + 1)]
    return np.array(path[:steps])


def offset_configuration(first: CrispConfiguration, offset: np.ndarray) -> CrispConfiguration:
    """Return a configuration turned and inserted by (needle, 4) degrees and mm from the first."""
    turns = np.array([turn(np.radians(vector)) for vector in offset[:, :3]])
    return CrispConfiguration(
        turns @ first.patient_from_entry, first.lengths_mm + offset[:, 3], first.loads
    )
