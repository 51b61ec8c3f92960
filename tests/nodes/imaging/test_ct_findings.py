"""What no anatomy is, is refused; what a reader must know, is told."""

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.imaging.ct_findings import Findings, refuse_findings
from nodes.imaging.ct_scan import CtScan
from tests.nodes.imaging.made_chest import NAMES, Chest, parameters, segmented


@pytest.fixture(scope="module")
def chest() -> Chest:
    return Chest()


def given(chest: Chest, origin: Origin = Origin("a person"), **drawn) -> LabelMap:  # noqa: B008
    labels = np.zeros(chest.labels.shape, np.uint8)
    for number, mask in enumerate(drawn.values(), start=1):
        labels[mask] = number
    return LabelMap(labels, chest.patient_from_index, tuple(drawn), origin)


def told(label_map: LabelMap) -> str:
    return "; ".join(label_map.origin.notices)


@pytest.mark.parametrize(
    "seeds", ["airway_seeds_patient_mm", "left_lung_seeds_patient_mm", "effusion_seeds_patient_mm"]
)
def test_a_seed_outside_of_the_body_is_refused(chest, seeds):
    with pytest.raises(BadInput, match=r"seed \[-145.0, -100.0, 0.0\] outside of the body"):
        segmented(chest, **{seeds: [(-145.0, -100.0, 0.0)]})


def test_an_airway_seed_in_a_lung_is_refused_whatever_grows_from_it(chest):
    with pytest.raises(BadInput, match="airway"):
        segmented(chest, airway_seeds_patient_mm=[(60.0, 0.0, 0.0)])


def test_an_airway_seed_in_tissue_is_refused(chest):
    with pytest.raises(BadInput, match="HU there"):
        segmented(chest, airway_seeds_patient_mm=[(0.0, -60.0, 0.0)])


def test_an_effusion_seed_from_which_nothing_grows_is_refused(chest):
    with pytest.raises(BadInput, match="no effusion grew from the 1 seeds"):
        segmented(chest, effusion_seeds_patient_mm=[(0.0, -60.0, 0.0)])


def test_an_effusion_under_the_skin_has_leaked(chest):
    scan = CtScan(chest.ct.voxels, chest.patient_from_index, np.zeros(chest.labels.shape, bool))
    deep, shallow = (chest.ball((x, 0.0, 0.0), 20.0) for x in (60.0, 128.0))
    labels = np.where(deep, 6, chest.labels).astype(np.uint8)
    refuse_findings(Findings(labels, NAMES, (), scan), parameters())
    labels[np.broadcast_to(shallow, labels.shape) & (labels > 0)] = 6
    with pytest.raises(BadInput, match="under the skin: the region has leaked"):
        refuse_findings(Findings(labels, NAMES, (), scan), parameters())
    refuse_findings(Findings(labels, NAMES, ("effusion",), scan), parameters())  # drawn by hand


def test_what_bringing_given_labels_here_cost_is_told_and_simulation_goes_on(chest):
    origin = Origin("a person", True, ("airway: brought from another grid (-4 %)",))
    found = segmented(chest, given(chest, origin, airway=chest.labels == 5))
    assert "brought from another grid (-4 %)" in told(found)
    assert "airway was given by hand" in told(found)
    assert found.origin.simulated


@pytest.mark.parametrize("name", ["Airway", "AIRWAY", "Left lung", "left-lung"])
def test_a_given_name_that_is_a_known_one_otherwise_written_is_refused(chest, name):
    plain = name.lower().replace(" ", "_").replace("-", "_")
    with pytest.raises(BadInput, match=rf"names: \{{{name}: {plain}\}}"):
        segmented(chest, given(chest, **{name: chest.labels == 5}))


def test_a_given_label_of_another_name_stands_beside_the_others_and_is_told(chest):
    found = segmented(chest, given(chest, nerve=chest.labels == 2))
    assert "nerve is none of the labels that are looked for" in told(found)


def test_given_lungs_on_the_wrong_sides_are_refused(chest):
    with pytest.raises(BadInput, match="mm to the right of right_lung"):
        segmented(chest, given(chest, left_lung=chest.labels == 4, right_lung=chest.labels == 3))
    segmented(chest, given(chest, left_lung=chest.labels == 3, right_lung=chest.labels == 4))


def test_air_without_a_label_and_small_lungs_are_told(chest):
    whole = segmented(chest)
    assert "no label" not in told(whole)
    disc = {"shape": "disc", "centre_patient_mm": (60.0, 0.0, 20.0), "normal_patient": (0, 0, 1),
            "radius_mm": 100.0, "thickness_mm": 9.0}  # fmt: skip
    cut = segmented(chest, barriers=[disc], usual_lungs_ml=(5000, 7000))
    assert "ml of air in the body have no label" in told(cut)
    assert "the lungs hold" in told(cut)
    assert "barriers made by hand: 1" in told(cut)


def test_labels_that_a_correction_wiped_out_are_called_empty_and_not_unfound(chest):
    ball = {"shape": "ball", "centre_patient_mm": (0.0, 0.0, 0.0), "radius_mm": 400.0}
    found = segmented(chest, corrections=[{"label": "background", "within": ball}])
    assert "the label body is empty" in told(found)
    assert "corrections made by hand: 1" in told(found)


@pytest.mark.parametrize(
    ("solid", "rule"),
    [
        ({"shape": "disc", "centre_patient_mm": (0, 0, 0), "normal_patient": (0, 0, 0),
          "radius_mm": 5.0, "thickness_mm": 5.0}, "normal_patient has a length"),
        ({"shape": "box", "lowest_patient_mm": (5, 0, 0), "highest_patient_mm": (0, 9, 9)},
         "lowest_patient_mm is below"),
    ],
)  # fmt: skip
def test_solids_that_are_none_are_refused_with_the_rule_that_they_break(chest, solid, rule):
    with pytest.raises(ValueError, match=rule):
        segmented(chest, barriers=[solid])
