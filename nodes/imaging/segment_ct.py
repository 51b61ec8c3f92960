"""Body, bone, lungs, airway and effusion in a CT, by region growing from seeds."""

from dataclasses import replace

import numpy as np
from jaxtyping import UInt8

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.imaging.ct_airway import find_airway
from nodes.imaging.ct_body import find_body, table_notices
from nodes.imaging.ct_bone import find_bone
from nodes.imaging.ct_effusion import find_effusion
from nodes.imaging.ct_findings import Findings, refuse_findings, refuse_misspelt, tell_findings
from nodes.imaging.ct_lungs import LEFT, RIGHT, fill_vessels, find_lungs
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import CtScan, Mask, turn_of, turned_transform
from nodes.imaging.hand_corrections import (
    barrier_mask,
    given_masks,
    paint_corrections,
    without_given,
)
from nodes.imaging.region_growing import refuse_seeds_outside

NAMES = ("body", "bone", "left_lung", "right_lung", "airway", "effusion")
SIDES = {LEFT: "left_lung", RIGHT: "right_lung"}


def segment_ct(ct: Volume, given_labels: LabelMap, parameters: SegmentCtParameters) -> LabelMap:
    """Label what is inside the skin: bone, lungs, airway, effusion, and all the rest as "body".

    A voxel has one label. What is grown is bounded by the person's barriers; labels that they
    give replace what would be found, and their corrections have the last word.

    Parameters
    ----------
    ct : CT in HU.
    given_labels : labels on the grid of `ct` that the person has drawn; without names, none.
    parameters : what to look for, thresholds and sizes, and the person's hand.

    Returns
    -------
    Label map on the grid of `ct`: the labels looked for, then further ones that were given.

    Raises
    ------
    BadInput where values are not HU, a label is not found that a chest must have, a region leaks,
    or a seed, barrier, correction or given label breaks a rule.
    """
    _refuse_other_units(ct)
    refuse_misspelt(given_labels.names)
    turn = turn_of(ct.patient_from_index)
    patient_from_turned = turned_transform(ct, turn)
    hu = turn.forth(ct.voxels)
    closed = barrier_mask(hu.shape, patient_from_turned, parameters.barriers)
    given = given_masks(given_labels, ct, turn)
    scan = without_given(CtScan(hu, patient_from_turned, closed), given)
    masks = _masks(scan, given, parameters)
    looked_for = [name for name in NAMES if name == "body" or name in parameters.labels]
    names = tuple(dict.fromkeys([*looked_for, *given]))
    labels = _painted(masks, names, hu.shape)
    paint_corrections(labels, patient_from_turned, names, parameters.corrections)
    found = Findings(labels, names, tuple(given), scan)
    refuse_findings(found, parameters)
    origin = replace(ct.origin, simulated=ct.origin.simulated or given_labels.origin.simulated)
    notices = [*given_labels.origin.notices, *tell_findings(found, parameters)]
    if "body" not in given:
        notices += table_notices(scan, labels > 0, parameters)
    return LabelMap(turn.back(labels), ct.patient_from_index, names, origin.with_notice(*notices))


def _refuse_other_units(ct: Volume) -> None:
    if ct.unit != "HU":
        raise BadInput(
            f"a volume in {ct.unit}",
            "thresholds in HU need a CT volume in HU",
            "give the CT as its scanner wrote it, or say with read_volume's hu_offset what makes"
            " its values HU; for an MRI use the pipelines head_mri or mri",
        )


def _masks(
    scan: CtScan, given: dict[str, Mask], parameters: SegmentCtParameters
) -> dict[str, Mask]:
    """Return all that is given or found; what comes later lies over what came before."""
    nothing = np.zeros(scan.hu.shape, bool)
    wanted = [name for name in parameters.labels if name not in given]
    body = given["body"] if "body" in given else find_body(scan, parameters)
    refuse_seeds_outside(scan, body, parameters)
    free = body & ~scan.closed
    airway = given.get("airway", nothing)
    if "airway" in wanted:
        airway = find_airway(scan, body, parameters)
    lungs, dents = _lungs(scan, free, airway, given, wanted, parameters)
    tissue = free & ~airway & ~np.logical_or.reduce([nothing, *lungs.values()])
    bone = find_bone(scan, tissue, parameters) if "bone" in wanted else given.get("bone", nothing)
    tissue &= ~bone
    effusion = given.get("effusion", nothing)
    if "effusion" in wanted:
        effusion = find_effusion(scan, tissue, lungs, dents, parameters)
    tissue &= ~effusion
    found = {"body": body, "bone": bone}
    found |= {SIDES[side]: lung for side, lung in lungs.items()}
    found |= {"airway": airway, "effusion": effusion}
    return found | given


def _lungs(
    scan: CtScan,
    free: Mask,
    airway: Mask,
    given: dict[str, Mask],
    wanted: list[str],
    parameters: SegmentCtParameters,
) -> tuple[dict[int, Mask], Mask]:
    """Return the lungs by side, given or found, and what was filled in those found."""
    lungs = {side: given[name] for side, name in SIDES.items() if name in given}
    dents = np.zeros(scan.hu.shape, bool)
    sought = [side for side, name in SIDES.items() if name in wanted]
    if sought:
        found = find_lungs(scan, free, airway, parameters)
        lungs |= {side: found[side] for side in sought if side in found}
    for side in sought:
        if side in lungs:
            others = [lung for other, lung in lungs.items() if other != side]
            tissue = free & ~np.logical_or.reduce([airway, *others])
            air = lungs[side]
            lungs[side] = fill_vessels(air, tissue, scan.spacing, parameters)
            dents |= lungs[side] & ~air
        else:
            raise BadInput(
                f"no {SIDES[side]} found in the CT",
                f"a lung is air below {parameters.lung_threshold_hu:g} HU in one part of"
                f" {parameters.smallest_lung_ml:g} ml or more on its side of the spine",
                "check that the series shows the chest and is in HU, give a point in the lung as"
                f" {SIDES[side]}_seeds_patient_mm, or take {SIDES[side]} out of labels",
            )
    return lungs, dents


def _painted(
    masks: dict[str, Mask], names: tuple[str, ...], shape: tuple[int, ...]
) -> UInt8[np.ndarray, "x y z"]:
    labels = np.zeros(shape, np.uint8)
    for name, mask in masks.items():
        if name in names:
            labels[mask] = names.index(name) + 1
    return labels
