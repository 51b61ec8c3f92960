"""Robots are read as people write them, and come back from their own file digit by digit."""

from dataclasses import fields

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from catalog.formats.configuration import (
    ConcentricTubeConfigurationFormat,
    CrispConfigurationFormat,
)
from catalog.formats.robot import ConcentricTubeRobotFormat, CrispSetupFormat, robot_kind
from nodes.errors import BadInput
from nodes.mechanics.check_robots import (
    check_concentric_tube_configuration,
    check_crisp_configuration,
)
from nodes.mechanics.constant_curvature import pose_chain
from nodes.mechanics.constant_curvature_tubes import arcs_of_robot
from nodes.mechanics.robots import (
    ConcentricTubeRobot,
    CrispSetup,
    Material,
    Needle,
    Snare,
    Tube,
)
from tests.catalog.formats.hostile import ORIGINS
from tests.conftest import ROOT

EXAMPLES = ROOT / "catalog" / "robots"
TUBE = {
    "material": "nitinol",
    "inner_diameter_mm": 0.8,
    "outer_diameter_mm": 1.1,
    "straight_length_mm": 100,
    "curved_length_mm": 50,
    "curvature_per_mm": "1e-2",
}
NEEDLE = {"material": "Nitinol", "inner_diameter_mm": 0.97, "outer_diameter_mm": 1.27}
ROBOT = {"robot": "concentric_tubes", "tubes": [TUBE]}
SETUP = {
    "robot": "crisp",
    "needles": [NEEDLE, NEEDLE],
    "entry_points_patient_mm": [[0, 0, 0], [100, 0, 0]],
    "snares": [{"needle": 1, "grasp_mm": 10}],
    "field_of_view_deg": 80,
}


def file(fields: dict) -> dict[str, bytes]:
    return {"any name.yml": yaml.safe_dump(fields, sort_keys=False).encode()}


def refused(form, fields: dict) -> str:
    with pytest.raises(BadInput) as caught:
        form.decode(file(fields))
    return str(caught.value)


def assert_same(one, other) -> None:
    """Field by field, arrays to the last bit."""
    assert type(one) is type(other)
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert a.tobytes() == b.tobytes() and a.shape == b.shape
        elif isinstance(a, tuple) and a and hasattr(a[0], "__dataclass_fields__"):
            for x, y in zip(a, b, strict=True):
                assert_same(x, y)
        else:
            assert a == b


numbers = st.floats(-1e3, 1e3)
lengths = st.floats(1e-3, 1e3)
rotations = st.tuples(*[st.floats(-3, 3)] * 3).map(lambda v: Rotation.from_rotvec(v).as_matrix())
materials = st.builds(
    Material,
    st.sampled_from(["nitinol", "stainless steel", "polycaprolactone", "other"]),
    st.floats(1, 1e6),
    st.floats(0, 0.5),
    st.floats(0.01, 0.2),
)


@st.composite
def robots(draw: st.DrawFn) -> ConcentricTubeRobot:
    count = draw(st.integers(1, 4))
    tubes = tuple(
        Tube(
            draw(materials),
            draw(st.floats(0.2, 0.3)) + 0.5 * i,
            draw(st.floats(0.5, 0.7)) + 0.5 * i,
            draw(lengths) + 3000 * (4 - i),
            draw(lengths),
            draw(st.floats(0, 0.005)),
        )
        for i in range(count)
    )
    pose = np.eye(4)
    pose[:3, :3] = draw(rotations)
    pose[:3, 3] = draw(st.tuples(numbers, numbers, numbers))
    limits = draw(st.none() | st.floats(-1e3, 0).map(lambda low: np.array([[low, np.inf]] * count)))
    turns = draw(st.none() | st.floats(-9, 0).map(lambda low: np.array([[low, 0.1]] * count)))
    return ConcentricTubeRobot(tubes, pose, draw(ORIGINS), limits, turns)


@st.composite
def setups(draw: st.DrawFn) -> CrispSetup:
    count = draw(st.integers(1, 4))
    needles = tuple(
        Needle(draw(materials), 0.5, 0.8, 1e-3 * np.array(draw(st.tuples(*[st.floats(-1, 1)] * 3))))
        for _ in range(count)
    )
    points = np.array([[draw(numbers), draw(numbers), 10.0 * i] for i in range(count)])
    snares = []
    for needle in draw(st.permutations(range(1, count))):
        joint = draw(st.sampled_from(["rigid", "relaxed"]))
        cosine = draw(st.floats(-0.9, 0.9)) if joint == "relaxed" else 0.0
        place = draw(st.sampled_from(["tip", "entry"]))
        snares.append(Snare(needle, draw(lengths), place, joint, cosine))
    angle = draw(st.floats(1, 179))
    return CrispSetup(needles, points, tuple(snares), angle, draw(ORIGINS))


@settings(max_examples=40)
@given(robots())
def test_a_concentric_tube_robot_comes_back_digit_by_digit(robot):
    written = ConcentricTubeRobotFormat.encode(robot)
    assert_same(ConcentricTubeRobotFormat.decode(written), robot)
    assert robot_kind(written["robot.yml"]) == "concentric_tubes"


@settings(max_examples=40)
@given(setups())
def test_a_crisp_setup_comes_back_digit_by_digit(setup):
    written = CrispSetupFormat.encode(setup)
    assert_same(CrispSetupFormat.decode(written), setup)
    assert robot_kind(written["setup.yml"]) == "crisp"


def test_what_a_file_leaves_out_is_told():
    told = ConcentricTubeRobotFormat.decode(file(ROBOT)).origin.notices
    assert any("nitinol: Young's modulus" in notice for notice in told)
    assert any("base" in notice for notice in told)
    told = CrispSetupFormat.decode(file(SETUP)).origin.notices
    assert any("from the tool's tip" in notice for notice in told)


def test_measured_constants_replace_the_literature():
    own = {"young_modulus_mpa": 58000, "poisson_ratio": 0.3, "recoverable_strain": 0.06}
    robot = ConcentricTubeRobotFormat.decode(file(ROBOT | {"tubes": [TUBE | own]}))
    assert robot.tubes[0].material == Material("nitinol", 58000.0, 0.3, 0.06)
    assert not any("literature" in notice for notice in robot.origin.notices)


def test_limits_are_written_in_degrees():
    robot = ConcentricTubeRobotFormat.decode(file(ROBOT | {"rotation_limits_deg": [[-90, 180]]}))
    np.testing.assert_allclose(robot.rotation_limits_rad, [[-np.pi / 2, np.pi]])
    told = refused(
        ConcentricTubeRobotFormat,
        ROBOT | {"rotation_limits_deg": [[0, 1]], "rotation_limits_rad": [[0, 1]]},
    )
    assert "written once" in told


def test_names_of_people_and_files_are_not_kept():
    robot = ConcentricTubeRobotFormat.decode(file({"name": "Doe^Jane", **ROBOT}))
    assert b"Jane" not in ConcentricTubeRobotFormat.encode(robot)["robot.yml"]
    assert b"any name" not in ConcentricTubeRobotFormat.encode(robot)["robot.yml"]
    assert "any name" not in refused(ConcentricTubeRobotFormat, ROBOT | {"tubes": 3})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"outer_diameter_mm": -1}, "tubes[0]: outer_diameter_mm = -1 mm"),
        ({"outer_diameter_mm": "wide"}, "tubes[0]: outer_diameter_mm = 'wide'"),
        ({"outer_diameter_mm": True}, "yes and no are no numbers"),
        ({"outer_diameter_mm": float("nan")}, "tubes[0]: outer_diameter_mm = nan"),
        ({"curvature_per_mm": 0.2}, "tubes[0]: curvature_per_mm = 0.2"),
        ({"inner_diameter_mm": 2}, "tubes[0]: inner_diameter_mm = 2"),
        ({"curved_lenght_mm": 2}, "did you mean curved_length_mm?"),
        ({"material": "nitinole"}, "did you mean nitinol?"),
        ({"material": "other"}, "write all three of them"),
        ({"poisson_ratio": 0.9}, "tubes[0]: poisson_ratio = 0.9"),
    ],
)
def test_a_wrong_line_of_a_tube_is_answered_with_its_place(change, told):
    assert told in refused(ConcentricTubeRobotFormat, ROBOT | {"tubes": [TUBE | change]})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"snares": [{"needle": 1, "grasp_mm": -3}]}, "snares[0]: grasp_mm = -3 mm"),
        ({"snares": [{"needle": 2, "grasp_mm": 3}]}, "needle 1 grasps 0 times"),
        ({"snares": [{"needle": 1.5, "grasp_mm": 3}]}, "snares[0]: needle = 1.5"),
        ({"snares": [{"needle": 1}]}, "snares[0]: grasp_mm is missing"),
        ({"snares": [{"needle": 1, "grasp_mm": 3, "joint": "glued"}]}, "snares[0]: joint"),
        (
            {"entry_points_patient_mm": [[0, 0, 0], [0, "x", 0]]},
            "entry_points_patient_mm.1.1 = 'x'",
        ),
        ({"entry_points_patient_mm": [[0, 0, 0], [0, 0, 1]]}, "enter 1 mm apart"),
        ({"entry_points_patient_mm": [[0, 0, 0]]}, "entry_points_patient_mm: 1"),
        ({"field_of_view_deg": 180}, "field_of_view_deg = 180 degrees"),
        ({"needles": [3, NEEDLE]}, "needles[0] = 3"),
        ({"needles": []}, "no needles"),
        ({"entry_points_patient_m": []}, "did you mean entry_points_patient_mm?"),
    ],
)
def test_a_wrong_line_of_a_setup_is_answered_with_its_place(change, told):
    assert told in refused(CrispSetupFormat, SETUP | change)


def test_a_file_of_the_other_robot_is_refused():
    assert "what is asked for is of crisp" in refused(CrispSetupFormat, ROBOT)


PAIRS = [
    ("concentric_tubes_three.yml", "concentric_tubes_three_configuration.yml"),
    ("yang2019_brain.yml", "yang2019_brain_configuration.yml"),
    ("crisp_two_snares.yml", "crisp_two_snares_configuration.yml"),
    ("crisp_two_snares.yml", "crisp_loaded_configuration.yml"),
]


def read(form, name: str):
    return form.decode({name: (EXAMPLES / name).read_bytes()})


@pytest.mark.parametrize(("robot", "configuration"), PAIRS)
def test_the_examples_can_be(robot, configuration):
    if robot_kind((EXAMPLES / robot).read_bytes()) == "crisp":
        check_crisp_configuration(
            read(CrispSetupFormat, robot), read(CrispConfigurationFormat, configuration)
        )
    else:
        check_concentric_tube_configuration(
            read(ConcentricTubeRobotFormat, robot),
            read(ConcentricTubeConfigurationFormat, configuration),
        )


def test_every_example_is_tried():
    assert {path.name for path in EXAMPLES.glob("*.yml")} == {
        name for pair in PAIRS for name in pair
    }


def test_the_example_of_the_paper_comes_to_its_target():
    """[Yang2019] test 4: (2, 27, 71) mm, as far as the rounded table lets it."""
    robot = read(ConcentricTubeRobotFormat, "yang2019_brain.yml")
    values = read(ConcentricTubeConfigurationFormat, "yang2019_brain_configuration.yml")
    tip = robot.patient_from_base @ pose_chain(arcs_of_robot(robot, values))[-1]
    assert np.linalg.norm(tip[:3, 3] - [2, 27, 71]) < 1
