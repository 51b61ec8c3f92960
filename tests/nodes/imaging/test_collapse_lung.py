"""A simulated collapse: nothing is lost, nothing floats, and everyone is told."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin
from nodes.imaging.collapse_lung import collapse_lung
from nodes.imaging.parameters import CollapseLungParameters

CATALOG = Path(__file__).resolve().parents[3] / "catalog" / "parameters"
DEFAULTS = CollapseLungParameters(**yaml.safe_load((CATALOG / "collapse_lung.yml").read_text()))
NAMES = ("body", "bone", "left_lung", "right_lung", "airway")
STEP = (4.0, 4.0, 5.0)


@cache
def chest(noise_sd=20.0) -> tuple[Volume, LabelMap]:
    """A body with two egg-shaped lungs (+x is left), a heart, a trachea and two bronchi."""
    axes = [(np.arange(n) - (n - 1) / 2) * s for n, s in zip((84, 60, 56), STEP, strict=True)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    labels = ((x / 160) ** 2 + (y / 112) ** 2 < 1).astype(np.uint8)
    lung = ((abs(x) - 75) / 62) ** 2 + (y / 90) ** 2 + (z / 125) ** 2 < 1
    lung &= ((x - 20) / 60) ** 2 + ((y + 40) / 45) ** 2 + ((z + 40) / 50) ** 2 > 1
    labels[lung & (x > 0)], labels[lung & (x < 0)] = 3, 4
    labels[(x**2 + y**2 < 81) & (z > 0)] = 5
    labels[(abs(x) < 60) & (y**2 + (z - 2) ** 2 < 49)] = 5
    labels[(abs(x) < 15) & (abs(y - 80) < 15)] = 2
    hu = np.array([-1000.0, 40, 600, -850, -850, -1000])[labels]
    hu[lung & (abs(y) < 6) & (abs(z) < 6)] = 40  # a vessel
    hu += np.random.default_rng(0).normal(size=hu.shape) * noise_sd
    patient_from_index = np.diag([*STEP, 1.0])
    patient_from_index[:3, 3] = [axis[0] for axis in axes]
    ct = Volume(np.rint(hu).astype(np.int16), patient_from_index, "HU", Origin("eggs"))
    return ct, LabelMap(labels, patient_from_index, NAMES, Origin("eggs"))


def collapsed(inputs=None, **values):
    ct, label_map = inputs or chest()
    return collapse_lung(ct, label_map, DEFAULTS.model_copy(update=values))


def parts_of(label_map, name):
    return ndimage.label(label_map.mask(name))[1]


def middle(label_map, name):
    index = np.array(ndimage.center_of_mass(label_map.mask(name)))
    return label_map.patient_from_index[:3, :3] @ index + label_map.patient_from_index[:3, 3]


@settings(max_examples=12, deadline=None)
@given(
    side=st.sampled_from(["left", "right"]),
    share=st.floats(0.1, 0.8),
    lies=st.sampled_from(["posterior", "anterior", "medial"]),
    flattening=st.floats(0.7, 2.5),
    adhesions=st.integers(0, 6),
    seed=st.integers(0, 1000),
)
def test_the_old_lung_becomes_lung_cavity_and_adhesions_and_nothing_else_changes(
    side, share, lies, flattening, adhesions, seed
):
    _, before = chest()
    _, after = collapsed(side=side, collapsed_share=share, lung_lies=lies, flattening=flattening,
                         adhesions=adhesions, seed=seed)  # fmt: skip
    name = f"{side}_lung"
    now = after.mask(name) | after.mask("pleural_cavity") | after.mask("adhesion")
    old = before.mask(name)
    np.testing.assert_array_equal(after.voxels[~now], before.voxels[~now])
    assert (now & ~before.mask("airway")).sum() >= old.sum() == (now & old).sum()
    # More than its label: only the bronchus in it and its wall.
    near = ndimage.binary_dilation(before.mask("airway"), iterations=2)
    assert (near | old)[now].all()
    assert 1 - after.mask(name).sum() / now.sum() == pytest.approx(share, abs=0.01)
    assert parts_of(after, name) == 1
    if adhesions == 0:
        assert parts_of(after, "pleural_cavity") == 1


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_collapsed_lung_lies_behind_its_cavity_and_hangs_on_its_hilum(side):
    _, after = collapsed(side=side, collapsed_share=0.6)
    behind = middle(after, f"{side}_lung")[1] - middle(after, "pleural_cavity")[1]
    assert behind > 15  # mm; +y is posterior
    _, before = chest()
    root = ndimage.binary_dilation(before.mask("airway") & ~(before.mask(f"{side}_lung")),
                                   iterations=3)  # fmt: skip
    assert (root & after.mask(f"{side}_lung")).any()


@pytest.mark.parametrize(("lies", "axis", "sign"), [("anterior", 1, -1), ("medial", 0, 1)])
def test_the_lung_lies_where_it_is_asked_to(lies, axis, sign):
    _, after = collapsed(lung_lies=lies, collapsed_share=0.6)  # right: medial is +x
    difference = middle(after, "right_lung") - middle(after, "pleural_cavity")
    assert sign * difference[axis] > 5


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_the_lung_keeps_its_mass(share):
    ct, before = chest(0.0)
    new, after = collapsed((ct, before), collapsed_share=share, adhesions=0)
    now = after.mask("right_lung") | after.mask("pleural_cavity")
    mass = [(volume.voxels[mask].astype(float) + 1000).clip(0).sum()
            for volume, mask in ((ct, now), (new, after.mask("right_lung")))]  # fmt: skip
    # The surface's voxels are part fluid: those add to the lung, and hold some of its tissue.
    assert mass[1] == pytest.approx(mass[0], rel=0.15)
    core = ndimage.binary_erosion(after.mask("right_lung"), iterations=2)
    expected = 150 / (1 - share)  # the density of the parenchyma; vessels cannot be pressed
    assert np.median(new.voxels[core]) + 1000 == pytest.approx(expected, rel=0.1)
    assert new.voxels[core].max() <= 60


@pytest.mark.parametrize(("filling", "hu"), [("fluid", 8.0), ("air", -1000.0)])
def test_the_cavity_holds_its_filling_with_the_noise_of_the_scan(filling, hu):
    new, after = collapsed(filling=filling, adhesions=0)
    core = ndimage.binary_erosion(after.mask("pleural_cavity"), iterations=2)
    values = new.voxels[core].astype(float)
    assert values.mean() == pytest.approx(hu, abs=2)
    assert values.std() == pytest.approx(20, rel=0.1)


def test_no_ring_of_lung_stays_around_the_fluid():
    new, after = collapsed(adhesions=0)
    cavity = after.mask("pleural_cavity")
    core = cavity & ~ndimage.binary_dilation(after.mask("right_lung"), iterations=2)
    assert new.voxels[core].min() > -150
    wall = ndimage.binary_dilation(core) & after.mask("body")
    assert new.voxels[wall].min() > -150


def test_adhesions_are_tissue_from_lung_to_chest_wall():
    new, after = collapsed(collapsed_share=0.7, adhesions=4, adhesion_width_mm=6.0)
    parts, count = ndimage.label(after.mask("adhesion"), np.ones((3, 3, 3)))
    assert 1 <= count <= 4
    wall = after.mask("body") | after.mask("bone")
    for number in range(1, count + 1):
        strand = parts == number
        around = ndimage.binary_dilation(strand, np.ones((3, 3, 3)))
        assert (around & after.mask("right_lung")).any() and (around & wall).any()
        assert abs(np.median(new.voxels[strand]) - 40) < 30


def test_no_air_of_the_airway_floats_in_the_cavity():
    _, after = collapsed(collapsed_share=0.7)
    assert parts_of(after, "airway") == 1


def test_the_inputs_stay_and_the_seed_decides():
    ct, label_map = chest()
    before = ct.voxels.copy(), label_map.voxels.copy()
    one, same, other = collapsed(), collapsed(), collapsed(seed=2)
    np.testing.assert_array_equal(ct.voxels, before[0])
    np.testing.assert_array_equal(label_map.voxels, before[1])
    np.testing.assert_array_equal(one[0].voxels, same[0].voxels)
    np.testing.assert_array_equal(one[1].voxels, same[1].voxels)
    assert (one[0].voxels != other[0].voxels).any()


def test_a_mirrored_chest_collapses_mirrored_on_the_other_side():
    ct, label_map = chest()
    mirror = np.diag([-1.0, 1, 1, 1])
    names = ("body", "bone", "right_lung", "left_lung", "airway")
    mirrored = (
        replace(ct, patient_from_index=mirror @ ct.patient_from_index),
        replace(label_map, patient_from_index=mirror @ label_map.patient_from_index, names=names),
    )
    new, after = collapsed(side="right", adhesions=4)
    new_mirrored, after_mirrored = collapsed(mirrored, side="left", adhesions=4)
    same = (after.voxels == after_mirrored.voxels).mean()
    assert same > 0.9999  # but for ties in the last digit
    np.testing.assert_allclose(
        new.voxels[after.voxels == 2], new_mirrored.voxels[after.voxels == 2]
    )


def test_axes_of_the_array_may_come_in_any_order():
    ct, label_map = chest()
    order = [2, 0, 1, 3]
    turned = tuple(
        replace(image, voxels=image.voxels.transpose(order[:3]),
                patient_from_index=image.patient_from_index[:, order])
        for image in (ct, label_map)
    )  # fmt: skip
    _, after = collapsed(adhesions=0)
    _, after_turned = collapsed(turned, adhesions=0)
    back = after_turned.voxels.transpose(np.argsort(order[:3]))
    assert (back == after.voxels).mean() > 0.999


def test_products_say_what_is_simulated():
    new, after = collapsed(filling="air", seed=5)
    for product in (new, after):
        assert product.origin.simulated
        told = " ".join(product.origin.notices)
        for word in ("simulated", "right_lung", "pleural_cavity", "adhesion", "air", "50%"):
            assert word in told
    assert after.names[-2:] == ("pleural_cavity", "adhesion")


def relabelled(name, keep=0.0):
    """The chest with most of a label turned into body."""
    ct, label_map = chest()
    voxels = label_map.voxels.copy()
    places = np.flatnonzero(voxels == NAMES.index(name) + 1)
    voxels.ravel()[places[int(keep * len(places)) :]] = 1
    return ct, replace(label_map, voxels=voxels)


def with_effusion():
    ct, label_map = chest()
    voxels = label_map.voxels.copy()
    voxels[(voxels == 4) & (np.indices(voxels.shape)[1] > 35)] = 6
    return ct, replace(label_map, voxels=voxels, names=(*NAMES, "effusion"))


def elsewhere():
    ct, label_map = chest()
    shifted = label_map.patient_from_index.copy()
    shifted[0, 3] += 4
    return ct, replace(label_map, patient_from_index=shifted)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: relabelled("right_lung"), "0 ml with the label right_lung"),
        (lambda: relabelled("right_lung", 0.05), "has at least 300 ml"),
        (lambda: (chest()[0], replace(chest()[1], names=("a", "b", "c", "d", "e"))), "right_lung"),
        (with_effusion, "healthy lungs"),
        (lambda: collapsed(side="left"), "healthy lungs"),
        (lambda: (replace(chest()[0], unit="intensity"), chest()[1]), "a volume in intensity"),
        (elsewhere, "lie on one grid"),
    ],
)
def test_what_cannot_collapse_is_refused(make, said):
    with pytest.raises(BadInput, match=said):
        collapsed(make())
