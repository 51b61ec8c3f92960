"""Segmentation of a CT against known anatomy, by hand, and on real scans."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.masks import connected_parts
from nodes.geometry.origin import Origin
from nodes.imaging.make_thorax_phantom import make_thorax_phantom
from nodes.imaging.parameters import MakeThoraxPhantomParameters, ReadVolumeParameters
from nodes.imaging.read_volume import read_volume
from nodes.imaging.score_segmentation import score_segmentation
from nodes.imaging.segment_ct import segment_ct
from tests.nodes.imaging.made_chest import (
    AIRWAY,
    BONE,
    DEFAULTS,
    EFFUSION,
    LEFT_LUNG,
    NAMES,
    NONE_GIVEN,
    RIGHT_LUNG,
    Chest,
    dice,
    parameters,
    segmented,
    turned,
)


def defaults(kind, stage, **changed):
    return kind(**{**yaml.safe_load((DEFAULTS / f"{stage}.yml").read_text()), **changed})


@pytest.fixture(scope="module")
def chest():
    return Chest()


@pytest.fixture(scope="module")
def found(chest):
    return segmented(chest)


@pytest.mark.parametrize("name", ["body", "bone", "left_lung", "right_lung", "airway"])
def test_cylinders_are_found(chest, found, name):
    assert found.names == NAMES
    assert dice(found.mask(name), chest.truth.mask(name)) >= 0.97


def test_a_healthy_chest_has_no_effusion_and_says_so(found):
    assert not found.mask("effusion").any()
    assert any(told.startswith("no effusion found") for told in found.origin.notices)


@pytest.mark.parametrize("noise", [5.0, 20.0])
def test_fluid_beside_muscle_is_found_in_noise(noise):
    chest = Chest(step=2.0, noise=noise, fluid_behind=25)
    labels = segmented(chest)
    effusion, truth = labels.mask("effusion"), chest.labels == EFFUSION
    assert dice(effusion, truth) >= 0.97
    assert effusion.sum() == pytest.approx(truth.sum(), rel=0.02)
    assert dice(labels.mask("right_lung"), chest.labels == RIGHT_LUNG) >= 0.97


def test_fluid_before_the_lung_is_found_as_well():
    chest = Chest(fluid_behind=None)
    chest.draw(chest.cavity(-1) & (chest.y < -35), 8, EFFUSION)
    assert dice(segmented(chest).mask("effusion"), chest.labels == EFFUSION) >= 0.97


def test_a_fatty_liver_below_the_lung_is_no_effusion():
    chest = Chest()
    chest.draw(chest.cavity(-1) & chest.ball((-65, 0, -90), 55), 10, 1)
    assert not segmented(chest).mask("effusion").any()


def test_lungs_stay_apart_when_they_touch():
    chest = Chest()
    bridge = (abs(chest.x) <= 24) & (chest.y < -50) & (chest.y > -60) & (abs(chest.z) < 60)
    chest.draw(bridge, -850, LEFT_LUNG)
    labels = segmented(chest)
    for name, number, sign in (("left_lung", LEFT_LUNG, 1), ("right_lung", RIGHT_LUNG, -1)):
        mask = labels.mask(name)
        assert len(connected_parts(mask)[1]) == 1
        beyond = mask & np.broadcast_to(sign * chest.x < -24, mask.shape)
        assert not beyond.any()
        assert dice(mask & ~bridge, (chest.labels == number) & ~bridge) >= 0.97


def leaking(lung_hu):
    """A chest whose right bronchus has a hole in its wall."""
    chest = Chest(lung_hu=lung_hu)
    chest.draw(chest.ball((-36, -10, 18), 6.5) & (chest.labels != AIRWAY), lung_hu, RIGHT_LUNG)
    return chest


def test_a_leak_into_the_lung_is_undone():
    chest = leaking(-850)
    airway = segmented(chest).mask("airway")
    assert dice(airway, chest.labels == AIRWAY) >= 0.9


def test_a_leak_that_no_threshold_stops_is_refused_and_a_barrier_cures_it():
    chest = leaking(-990)
    with pytest.raises(BadInput, match="largest_airway_ml"):
        segmented(chest, gas_mean_hu=-1020.0)
    barrier = {"shape": "ball", "centre_patient_mm": (-36, -10, 18), "radius_mm": 8.0}
    labels = segmented(chest, gas_mean_hu=-1020.0, barriers=[barrier])
    assert dice(labels.mask("airway"), chest.labels == AIRWAY) >= 0.9


def test_a_region_beyond_anatomy_is_refused_with_its_volume():
    with pytest.raises(BadInput, match=r"left_lung of \d+ ml: the region has leaked"):
        segmented(Chest(), largest_lung_ml=500.0)


def test_seeds_find_what_is_not_found_by_itself():
    chest = Chest(fluid_behind=25)
    chest.hu[chest.labels == EFFUSION] = 28  # denser than fluid that is looked for
    assert not segmented(chest).mask("effusion").any()
    labels = segmented(chest, effusion_seeds_patient_mm=[(-60, 40, 0)], effusion_smoothing_mm=2.0)
    assert dice(labels.mask("effusion"), chest.labels == EFFUSION) >= 0.95


def test_seeds_of_the_lungs_overrule_the_sides():
    labels = segmented(
        Chest(),
        left_lung_seeds_patient_mm=[(-60, 0, 0)],
        right_lung_seeds_patient_mm=[(60, 0, 0)],
    )
    assert labels.mask("left_lung")[30, 35, 35] and labels.mask("right_lung")[70, 35, 35]


def test_an_airway_seed_replaces_the_search_for_the_trachea():
    chest = Chest()
    short = {"shortest_trachea_mm": 200.0}
    with pytest.raises(BadInput, match="no trachea found"):
        segmented(chest, **short)
    labels = segmented(chest, airway_seeds_patient_mm=[(0, -10, 60)], **short)
    assert dice(labels.mask("airway"), chest.labels == AIRWAY) >= 0.97


def test_what_is_given_is_taken_as_it_is_and_kept_under_its_name(chest):
    drawn = np.zeros(chest.labels.shape, np.uint8)
    drawn[60:70, 30:40, 20:30], drawn[20:25, 30:40, 20:30] = 1, 2
    given_labels = LabelMap(
        drawn, chest.patient_from_index, ("left_lung", "nodule"), Origin("by hand")
    )
    labels = segmented(chest, given_labels)
    assert labels.names == (*NAMES, "nodule")
    np.testing.assert_array_equal(labels.mask("left_lung"), drawn == 1)
    np.testing.assert_array_equal(labels.mask("nodule"), drawn == 2)
    assert {"left_lung was given by hand", "nodule was given by hand"} <= set(labels.origin.notices)


def test_given_labels_on_another_grid_are_refused(chest):
    drawn = np.ones(chest.labels.shape, np.uint8)
    for voxels, grid in (
        (drawn[1:], chest.patient_from_index),
        (drawn, np.diag([3.1, 3, 3, 1])),
    ):
        with pytest.raises(BadInput, match="lie on the image's grid"):
            segmented(chest, LabelMap(voxels, grid, ("bone",), Origin("by hand")))


def test_corrections_have_the_last_word_in_their_order(chest):
    big = {"shape": "ball", "centre_patient_mm": (60, 0, 0), "radius_mm": 12.0}
    small = {"shape": "ball", "centre_patient_mm": (60, 0, 0), "radius_mm": 5.0}
    labels = segmented(
        chest,
        corrections=[{"label": "bone", "within": big}, {"label": "background", "within": small}],
    )
    inner, outer = chest.ball((60, 0, 0), 5), chest.ball((60, 0, 0), 12)
    assert (labels.voxels[inner] == 0).all() and (labels.voxels[outer & ~inner] == BONE).all()
    assert "corrections made by hand: 2" in labels.origin.notices


@settings(max_examples=6, deadline=None)
@given(st.permutations([0, 1, 2]), st.tuples(*[st.booleans()] * 3))
def test_the_same_places_get_the_same_labels_however_the_scan_is_stored(axes, flips):
    chest = Chest(step=5.0, fluid_behind=30)
    ball = {"shape": "ball", "centre_patient_mm": (50, 0, 0), "radius_mm": 11.0}
    changed = parameters(
        corrections=[{"label": "bone", "within": ball}], effusion_seeds_patient_mm=[(-60, 45, 0)]
    )
    straight = segment_ct(chest.ct, NONE_GIVEN, changed)
    other = segment_ct(turned(chest.ct, axes, flips), NONE_GIVEN, changed)
    np.testing.assert_array_equal(other.voxels, turned(straight, axes, flips).voxels)


def plain(hu):
    return Volume(np.full((20, 20, 20), hu, np.int16), np.diag([5.0, 5, 5, 1]), "HU", Origin("x"))


@pytest.mark.parametrize(
    ("hu", "labels", "words"),
    [
        (-1000, ["body"], "no body"),
        (40, ["airway"], "no trachea"),
        (40, ["left_lung"], "no left_lung"),
        (40, ["right_lung"], "no right_lung"),
    ],
)
def test_what_must_be_there_and_is_missing_is_named(hu, labels, words):
    with pytest.raises(BadInput, match=words):
        segment_ct(plain(hu), NONE_GIVEN, parameters(labels=labels))


def test_what_is_not_looked_for_is_not_missed():
    labels = segment_ct(plain(40), NONE_GIVEN, parameters("segment_head_ct"))
    assert labels.names == ("body", "bone") and (labels.voxels == 1).all()
    assert "the label bone is empty" in labels.origin.notices


def test_values_that_are_not_hounsfield_units_are_refused():
    with pytest.raises(BadInput, match="intensity"):
        segment_ct(replace(plain(40), unit="intensity"), NONE_GIVEN, parameters())


def test_metal_is_told_and_counts_as_bone(chest):
    other = Chest()
    other.draw(other.ball((0, 60, 0), 8), 3071, BONE)
    labels = segmented(other, stage="segment_head_ct")
    assert labels.mask("bone")[other.ball((0, 60, 0), 8)].all()
    assert any("dense as metal" in notice for notice in labels.origin.notices)
    assert not any("metal" in notice for notice in segmented(chest, labels=["bone"]).origin.notices)


def test_phantom_agrees_with_its_truth_and_leaves_the_table_out():
    files, truth = make_thorax_phantom(
        defaults(
            MakeThoraxPhantomParameters,
            "make_thorax_phantom",
            pixel_spacing_mm=2.0,
        )
    )
    ct = read_volume(files, defaults(ReadVolumeParameters, "read_volume"))
    labels = segment_ct(ct, NONE_GIVEN, parameters())
    scores = score_segmentation(labels, truth).set_index("label")
    assert scores.dice["lungs"] >= 0.97 and scores.dice["effusion"] >= 0.95
    assert scores.dice["bone"] >= 0.95 and scores.dice["airway"] >= 0.90
    assert (labels.voxels[truth.voxels == 0] > 0).mean() < 0.01
    assert labels.origin.simulated


@pytest.fixture(scope="module")
def real(test_data):
    from catalog.formats.image_files import ImageFilesFormat

    path = test_data / "chest_ct" / "normal001_half.nii.gz"
    files = ImageFilesFormat.decode({path.name: path.read_bytes()})
    ct = read_volume(files, defaults(ReadVolumeParameters, "read_volume"))
    return segment_ct(ct, NONE_GIVEN, parameters())


def millilitres(labels, name):
    return labels.mask(name).sum() * abs(np.linalg.det(labels.patient_from_index)) / 1000


def test_a_real_chest_has_a_lung_in_one_part_on_each_side(real):
    assert 2500 < millilitres(real, "left_lung") + millilitres(real, "right_lung") < 7000
    middles = []
    for name in ("left_lung", "right_lung"):
        assert len(connected_parts(real.mask(name))[1]) == 1
        index = np.argwhere(real.mask(name)).mean(axis=0)
        middles.append((real.patient_from_index[:3, :3] @ index)[0])
    assert middles[0] - middles[1] > 100  # mm to the left


def test_a_real_airway_is_one_tree_that_reaches_both_lungs_without_leaking(real):
    airway = real.mask("airway")
    assert len(connected_parts(airway)[1]) == 1
    assert 15 < millilitres(real, "airway") < 80
    x, _, z = (np.flatnonzero(airway.any(axis=axes)) for axes in ((1, 2), (0, 2), (0, 1)))
    assert np.ptp(z) * 2.0 > 90 and np.ptp(x) * 1.27 > 70  # mm: trachea, and both main bronchi


def test_a_real_healthy_chest_has_bone_of_human_size_and_no_effusion(real):
    assert 400 < millilitres(real, "bone") < 2000
    assert not real.mask("effusion").any()
