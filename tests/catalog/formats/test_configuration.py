"""Joint values are read in degrees and in each form of an orientation."""

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from catalog.formats.configuration import (
    ConcentricTubeConfigurationFormat,
    CrispConfigurationFormat,
)
from nodes.errors import BadInput
from nodes.mechanics.robots import ConcentricTubeConfiguration, CrispConfiguration, PointLoad

TUBES = {"robot": "concentric_tubes", "rotations_deg": [90, -45], "translations_mm": [-2, -1]}
CRISP = {"robot": "crisp", "lengths_mm": [200], "orientations": [{"direction": [0, 0, 1]}]}
numbers = st.floats(-1e3, 1e3)
vectors = hnp.arrays(float, 3, elements=numbers)


def file(fields: dict) -> dict[str, bytes]:
    return {"x.yml": yaml.safe_dump(fields).encode()}


def refused(form, fields: dict) -> str:
    with pytest.raises(BadInput) as caught:
        form.decode(file(fields))
    return str(caught.value)


@given(st.integers(1, 4).flatmap(lambda n: hnp.arrays(float, (2, n), elements=numbers)))
def test_joint_values_of_tubes_come_back_digit_by_digit(values):
    written = ConcentricTubeConfigurationFormat.encode(ConcentricTubeConfiguration(*values))
    read = ConcentricTubeConfigurationFormat.decode(written)
    assert read.rotations_rad.tobytes() == values[0].tobytes()
    assert read.translations_mm.tobytes() == values[1].tobytes()


@settings(max_examples=50)
@given(st.lists(st.tuples(vectors, numbers), max_size=3), st.lists(st.tuples(vectors, vectors)))
def test_joint_values_of_needles_come_back_digit_by_digit(needles, pulls):
    turns = Rotation.from_rotvec([vector for vector, _ in needles] or np.zeros((0, 3))).as_matrix()
    lengths = np.array([length for _, length in needles], float)
    loads = tuple(PointLoad(1.5 * i, *pull) for i, pull in enumerate(pulls))
    value = CrispConfiguration(turns, lengths, loads)
    read = CrispConfigurationFormat.decode(CrispConfigurationFormat.encode(value))
    assert read.patient_from_entry.tobytes() == value.patient_from_entry.tobytes()
    assert read.lengths_mm.tobytes() == value.lengths_mm.tobytes()
    for one, other in zip(read.loads, loads, strict=True):
        assert one.arc_length_mm == other.arc_length_mm
        assert one.force_n.tobytes() == other.force_n.tobytes()
        assert one.moment_n_mm.tobytes() == other.moment_n_mm.tobytes()


def test_rotations_are_written_in_degrees():
    read = ConcentricTubeConfigurationFormat.decode(file(TUBES))
    np.testing.assert_allclose(read.rotations_rad, [np.pi / 2, -np.pi / 4])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"rotations_rad": [0, 0]}, "written once"),
        ({"rotations_deg": None}, "no rotations_deg"),
        ({"rotations_deg": [1]}, "1 rotations and 2 translations"),
        ({"rotations_deg": [1, "x"]}, "rotations_deg.1 = 'x'"),
        ({"translation_mm": [1, 2]}, "did you mean translations_mm?"),
        ({"robot": "crisp"}, "what is asked for"),
    ],
)
def test_wrong_lines_of_tubes_are_answered(change, told):
    assert told in refused(ConcentricTubeConfigurationFormat, TUBES | change)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"orientations": []}, "1 lengths and 0 orientations"),
        ({"orientations": [{}]}, "orientations[0]: no orientation"),
        ({"orientations": [{"direction": [0, 0, 0]}]}, "orientations[0]: direction"),
        ({"loads": [{"arc_length_mm": -1, "force_n": [0, 0, 1]}]}, "loads[0]: arc_length_mm = -1"),
        ({"loads": [{"arc_length_mm": 1}]}, "loads[0]: force_n is missing"),
        ({"loads": [{"arc_length_mm": 1, "force_n": [0, 1]}]}, "loads[0]: force_n"),
        ({"lengths_mm": [".inf"]}, "lengths_mm.0"),
    ],
)
def test_wrong_lines_of_needles_are_answered(change, told):
    assert told in refused(CrispConfigurationFormat, CRISP | change)
