"""Motions of a CRISP robot as the files that people open: joint values as CSV, needles as curves.

`motion.csv` has all digits and restores the motion; `needles.vtp` shows the needles at every step,
and `tip_path.mrk.json` the way of the camera in 3D Slicer.
"""

import csv
from collections.abc import Mapping, Sequence
from io import StringIO

import numpy as np
from jaxtyping import Float

from catalog.formats.markups_file import SCHEMA
from catalog.formats.plain_values import FRAME, to_json
from catalog.formats.vtp_file import write_curves
from nodes.errors import BadInput
from nodes.mechanics.describe_robots import name_needle
from nodes.mechanics.robots import CrispSetup
from nodes.mechanics.sample_crisp_needles import sample_crisp_needles
from nodes.planning.artefacts import CrispMotion, PlacedSetup

PIECES = 20  # of each needle's curve before a joint


def write_motion(
    motion: CrispMotion, placed: PlacedSetup, columns: Mapping[str, np.ndarray], note: str
) -> dict[str, bytes]:
    """Return the files of one motion; none where there is no motion.

    Parameters
    ----------
    columns : further values of each step for the table, by name.
    note : what a reader must know; stands in every file.
    """
    if not len(motion.lengths_mm):
        return {}
    return {
        "motion.csv": _write_csv(motion, columns, note),
        "needles.vtp": _write_needles(motion, placed.setup, note),
        "tip_path.mrk.json": _write_path(motion, note),
    }


def read_motion(
    files: Mapping[str, bytes], needles: int, columns: Sequence[str] = ()
) -> tuple[CrispMotion, list[np.ndarray]]:
    """Return the motion and the further columns of `write_motion`."""
    rows = list(csv.reader(StringIO(files.get("motion.csv", b"").decode("ascii"), newline="")))
    names, numbers = _names(needles), np.array([row[1:-1] for row in rows[1:]], float)
    numbers = numbers.reshape(-1, len(names) + len(columns))
    joints = numbers[:, : 16 * needles].reshape(-1, needles, 16)
    pose = np.tile(np.eye(4), (len(numbers), 1, 1))
    pose[:, :3] = numbers[:, 16 * needles : len(names)].reshape(-1, 3, 4)
    motion = CrispMotion(
        joints[:, :, :9].reshape(-1, needles, 3, 3), joints[:, :, 9], joints[:, :, 10:], pose
    )
    return motion, [np.array(numbers[:, len(names) + at]) for at in range(len(columns))]


def _names(needles: int) -> list[str]:
    """Return the columns of a motion: joint values and wrenches of each needle, then the camera."""
    names = []
    for needle in range(needles):
        name = name_needle(needle).replace(" ", "_")
        names += [f"{name}_axis_{axis}_{i}" for i in "xyz" for axis in "xyz"]
        names += [f"{name}_length_mm"]
        names += [f"{name}_moment_{i}_n_mm" for i in "xyz"] + [f"{name}_force_{i}_n" for i in "xyz"]
    for i in "xyz":
        names += [f"camera_right_{i}", f"camera_down_{i}", f"camera_view_{i}", f"camera_{i}_mm"]
    return names


def _write_csv(motion: CrispMotion, columns: Mapping[str, np.ndarray], note: str) -> bytes:
    steps, needles = motion.lengths_mm.shape
    joints = np.concatenate(
        [motion.orientations.reshape(steps, needles, 9), motion.lengths_mm[..., None],
         motion.wrenches], axis=2,
    ).reshape(steps, -1)  # fmt: skip
    camera = motion.patient_from_camera[:, :3].reshape(steps, -1)
    numbers = np.column_stack([joints, camera, *columns.values()])
    text = StringIO(newline="")
    rows = csv.writer(text)
    rows.writerow(["step", *_names(needles), *columns, "note"])
    for step, row in enumerate(numbers.tolist()):
        rows.writerow([step, *map(repr, row), f"{FRAME}; {note}"])
    return text.getvalue().encode("ascii", "xmlcharrefreplace")


def _write_needles(motion: CrispMotion, setup: CrispSetup, note: str) -> bytes:
    """Return all needles at all steps as curves that know step, needle and radius."""
    curves = _curves(motion, setup)
    sizes = [len(points) for _, _, points in curves]
    radii = [needle.outer_diameter_mm / 2 for needle in setup.needles]
    data = {
        "step": np.repeat(np.array([step for step, _, _ in curves], np.int64), sizes),
        "needle": np.repeat(np.array([needle for _, needle, _ in curves], np.int64), sizes),
        "outer_radius_mm": np.repeat(np.array([radii[n] for _, n, _ in curves]), sizes),
    }
    return write_curves([points for _, _, points in curves], data, [f"{FRAME}; {note}"])


def _curves(
    motion: CrispMotion, setup: CrispSetup
) -> list[tuple[int, int, Float[np.ndarray, "point 3"]]]:
    try:
        points = sample_crisp_needles(
            setup, motion.orientations, motion.lengths_mm, motion.wrenches, PIECES
        )
    except BadInput:  # a motion that no robot can make: the verdict says it, there is no shape
        return []
    tool = motion.lengths_mm[0, 0]
    places = [s.grasp_mm if s.measured_from == "entry" else tool - s.grasp_mm for s in setup.snares]
    order = [setup.snares[at].needle for at in np.argsort(places, kind="stable")]
    return [
        curve
        for step in range(len(motion.lengths_mm))
        for curve in [
            (step, 0, points.tool_patient_mm[step]),
            *((step, n, points.snares_patient_mm[step, at]) for at, n in enumerate(order)),
        ]
    ]


def _write_path(motion: CrispMotion, note: str) -> bytes:
    """Return the places of the camera as a curve of 3D Slicer."""
    points = [
        {"label": str(step), "position": pose[:3, 3].tolist(), "positionStatus": "defined",
         "orientation": pose[:3, :3].ravel().tolist(), "description": note}
        for step, pose in enumerate(motion.patient_from_camera)
    ]  # fmt: skip
    markup = {
        "type": "Curve",
        "coordinateSystem": "LPS",
        "coordinateUnits": "mm",
        "controlPoints": points,
    }
    return to_json({"@schema": SCHEMA, "markups": [markup]})
