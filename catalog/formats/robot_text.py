"""What all robot and configuration files share: one YAML file, named places, orientations.

People write mm, MPa, N, and degrees with the suffix `_deg`. Only known keys are read; a `name`
may stand there for the reader and is not kept. Of free text only that of an `origin`, which our own
files hold, passes on to pages: write no patient's name there.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from typing import Annotated, Any, TypeVar

import numpy as np
import yaml
from jaxtyping import Float
from pydantic import BaseModel, BeforeValidator, ConfigDict, FiniteFloat

from catalog.validation import unknown, validate
from catalog.yaml_file import parse_mapping
from nodes.errors import BadInput
from nodes.geometry.origin import Origin

Model = TypeVar("Model", bound=BaseModel)
KINDS = ("concentric_tubes", "crisp")
# What people write has few decimals: nearer than this to a rotation it is taken for one.
WRITTEN_TOLERANCE = 1e-3
# What is nearer than this was written with all digits, and is kept digit by digit.
EXACT_TOLERANCE = 1e-9


def _no_truth(value: Any) -> Any:
    if isinstance(value, bool):
        raise ValueError("yes and no are no numbers")
    return value


Number = Annotated[FiniteFloat, BeforeValidator(_no_truth)]
Limit = Annotated[float, BeforeValidator(_no_truth)]  # infinite where there is none
Vector = tuple[Number, Number, Number]


class Closed(BaseModel):
    """What a person writes; a key that is not known is refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class OriginText(Closed):
    """Where a robot comes from, as it was written before."""

    source: str
    """in plain words, without any patient's identifier"""
    simulated: bool
    """whether any part of it is simulated"""
    notices: tuple[str, ...]
    """what a reader must know"""


class Orientation(Closed):
    """How something is turned in the patient, in one of three ways."""

    rotation: tuple[Vector, Vector, Vector] | None = None
    """3 x 3, its columns the own axes in patient LPS, the third one along the needle or base"""
    quaternion: tuple[Number, Number, Number, Number] | None = None
    """w, x, y, z from own axes to patient LPS"""
    direction: Vector | None = None
    """where it points, in patient LPS, of any length; turned the shortest way from patient +z"""
    roll_deg: Number | None = None
    """turn about the direction after that, degrees; 0 where it is left out"""


def robot_kind(content: bytes) -> str:
    """Return "concentric_tubes" or "crisp": what a robot's or configuration's file says it is of.

    Raises
    ------
    BadInput where it says nothing or something else.
    """
    return _kind(parse_mapping(content, "the robot's file", "open it"))


def _kind(values: Mapping[str, Any]) -> str:
    if "robot" not in values:
        raise BadInput(
            "the key robot is missing",
            "a robot's and a configuration's file say what they are of",
            f"add a line `robot: ...`, one of: {', '.join(KINDS)}",
        )
    if values["robot"] not in KINDS:
        raise unknown("robot", str(values["robot"]), KINDS)
    return values["robot"]


def read_file(files: Mapping[str, bytes], kind: str, model: type[Model]) -> Model:
    """Return what the one file holds, as that type.

    Raises
    ------
    BadInput for none or several files, another kind of robot, or a value that breaks a rule.
    """
    if len(files) != 1:
        raise BadInput(
            f"{len(files)} files", "a robot or configuration is one YAML file", "name that file"
        )
    values = parse_mapping(next(iter(files.values())), "the robot's file", "open it")
    found = _kind(values)
    if found != kind:
        raise BadInput(f"robot: {found}", f"what is asked for is of {kind}", "name another file")
    known = {key: value for key, value in values.items() if key not in ("robot", "name")}
    return validate(model, known, "the robot's file")


def read_part(model: type[Model], values: Any, place: str) -> Model:
    """Return one part of a file as its type; its errors name the place."""
    if not isinstance(values, Mapping):
        raise BadInput(
            f"{place} = {values!r}", "it holds lines `key: value`", "write its keys below it"
        )
    return validate(model, values, place)


def read_parts(model: type[Model], values: Sequence[Any], place: str) -> list[Model]:
    """Return the items of a list in a file as their type."""
    return [read_part(model, part, f"{place}[{index}]") for index, part in enumerate(values)]


@contextmanager
def at(place: str) -> Iterator[None]:
    """Let the errors of what is made from one part of a file name its place."""
    try:
        yield
    except BadInput as error:
        raise BadInput(f"{place}: {error.value}", error.rule, error.cure) from error


def to_origin(written: OriginText | None, source: str, notices: Sequence[str]) -> Origin:
    """Return the origin that a file tells, or that source, with what else a reader must know."""
    origin = Origin(source)
    if written:
        origin = Origin(written.source, written.simulated, written.notices)
    return origin.with_notice(*notices) if notices else origin


def write_file(name: str, kind: str, fields: dict[str, Any], origin: Origin | None = None) -> dict:
    """Return the one file, all numbers with all digits."""
    values = {"robot": kind, **fields}
    if origin:
        values["origin"] = asdict(origin) | {"notices": list(origin.notices)}
    text = yaml.safe_dump(values, sort_keys=False, default_flow_style=None, width=100)
    return {name: text.encode("utf-8")}


def to_rotation(written: Orientation, place: str) -> Float[np.ndarray, "3 3"]:
    """Return the rotation from own axes to the patient that a person wrote.

    A direction is reached the shortest way, Rz(a) Ry(p) Rz(-a) with its azimuth a and its angle p
    to patient +z, and then turned about itself; for patient -z, a = 0.

    Raises
    ------
    BadInput unless exactly one way is written, and that is a rotation, a quaternion of length 1, or
    a direction that is not zero.
    """
    ways = {
        "rotation": written.rotation,
        "quaternion": written.quaternion,
        "direction": written.direction,
    }
    given = [way for way, value in ways.items() if value is not None]
    if len(given) != 1 or (written.roll_deg is not None and given != ["direction"]):
        found = given + ["roll_deg"] * (written.roll_deg is not None)
        raise BadInput(
            f"{place}: {', '.join(found) or 'no orientation'}",
            "an orientation is one of rotation, quaternion, and direction with or without roll_deg",
            "keep one of them",
        )
    values = np.array(ways[given[0]], float)
    if written.rotation:
        return _nearest_rotation(values, place)
    if written.quaternion:
        return _from_quaternion(values, place)
    return _along(values, written.roll_deg or 0.0, place)


def _nearest_rotation(written: Float[np.ndarray, "3 3"], place: str) -> Float[np.ndarray, "3 3"]:
    off = float(abs(written.T @ written - np.eye(3)).max())
    if off > WRITTEN_TOLERANCE or np.linalg.det(written) < 0:
        raise BadInput(
            f"{place}: rotation = {written.tolist()}",
            "the columns have length 1, are at right angles"
            f" (to {WRITTEN_TOLERANCE:g}) and right-handed",
            "write the three own axes as columns, or give a direction",
        )
    if off <= EXACT_TOLERANCE:
        return written
    left, _, right = np.linalg.svd(written)
    return left @ right


def _from_quaternion(written: Float[np.ndarray, "4"], place: str) -> Float[np.ndarray, "3 3"]:
    from scipy.spatial.transform import Rotation

    if abs(np.linalg.norm(written) - 1) > WRITTEN_TOLERANCE:
        raise BadInput(
            f"{place}: quaternion = {written.tolist()}",
            f"w, x, y, z have length 1 (to {WRITTEN_TOLERANCE:g})",
            "divide them by their length",
        )
    return Rotation.from_quat(written, scalar_first=True).as_matrix()


def _along(
    direction: Float[np.ndarray, "3"], roll_deg: float, place: str
) -> Float[np.ndarray, "3 3"]:
    from scipy.spatial.transform import Rotation

    x, y, z = direction
    if not direction.any():
        raise BadInput(
            f"{place}: direction = {direction.tolist()}", "a direction is not zero", "write another"
        )
    azimuth, polar = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)
    turns = [azimuth, polar, np.radians(roll_deg) - azimuth]
    return Rotation.from_euler("ZYZ", turns).as_matrix()
