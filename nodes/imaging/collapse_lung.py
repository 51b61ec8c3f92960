"""A simulated pleural cavity with a collapsed lung, made from the CT of a healthy chest."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float, UInt8

from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, Volume, voxel_volume_mm3
from nodes.geometry.masks import Mask, bounding_box, connected_parts
from nodes.geometry.origin import Origin
from nodes.imaging.lung_adhesions import Parts, draw_adhesions
from nodes.imaging.lung_deformation import coarsen, find_hilum, fit_collapse
from nodes.imaging.lung_filling import Scene, fill
from nodes.imaging.lung_parts import settle_lung, whole_lung
from nodes.imaging.parameters import CollapseLungParameters

ML_IN_MM3 = 1000.0
CAVITY, ADHESION = "pleural_cavity", "adhesion"
MARGIN = 3  # voxels around the lung that its edge reaches into


def collapse_lung(
    ct: Volume, label_map: LabelMap, parameters: CollapseLungParameters
) -> tuple[Volume, LabelMap]:
    """Let one lung of a healthy chest collapse, and fill the room that it leaves.

    The collapsed lung lies on one side of the cavity, hangs on its hilum, and holds the tissue of
    the healthy one in less space. The old lung (its label, with the bronchi and vessels that it
    surrounds) becomes collapsed lung, "pleural_cavity" and "adhesion"; else nothing changes but
    the values of the voxels at its edge.

    Parameters
    ----------
    ct : chest CT in HU.
    label_map : on the grid of `ct`, with "left_lung" or "right_lung"; "airway" helps to find the
        hilum.
    parameters : side, share, place, filling, adhesions.

    Returns
    -------
    ct : the simulated CT.
    label_map : its labels: those of the input, and "pleural_cavity" and "adhesion".

    Raises
    ------
    BadInput where values are not HU, grids differ, the lung is missing or small, or there is an
    effusion already.
    """
    name, side = f"{parameters.side}_lung", 1 if parameters.side == "left" else -1
    _check(ct, label_map, name, parameters)
    lung = whole_lung(label_map, name, parameters)
    box = bounding_box(lung, MARGIN)
    patient_from_box = _moved(ct.patient_from_index, box)
    region = coarsen(lung[box], patient_from_box, parameters.smoothing_mm)
    hilum = find_hilum(region, _places(label_map, "airway"), side)
    collapse = fit_collapse(region, hilum, parameters)
    settled = settle_lung(lung[box], patient_from_box, region, collapse, parameters)
    parts = Parts(settled.lung, lung[box] & ~settled.lung, patient_from_box, side)
    chance = np.random.default_rng(parameters.seed)
    strands, count = draw_adhesions(parts, parameters, chance)
    labels = _relabelled(label_map, name, box, parts, strands)
    scene = Scene(ct.voxels[box], _tissue(label_map)[box], patient_from_box)
    values = fill(scene, parts, strands, settled, collapse, parameters, chance)
    voxels = ct.voxels.copy()
    voxels[box] = values
    origin = _origin(ct.origin, label_map.origin, name, labels, count, parameters)
    return (
        replace(ct, voxels=voxels, origin=origin),
        replace(labels, origin=origin),
    )


def _check(ct: Volume, label_map: LabelMap, name: str, parameters: CollapseLungParameters) -> None:
    if ct.unit != "HU":
        raise BadInput(
            f"a volume in {ct.unit}",
            "a lung is collapsed in a CT volume in HU",
            "give the CT as its scanner wrote it",
        )
    same_place = np.allclose(ct.patient_from_index, label_map.patient_from_index, atol=1e-3)
    if ct.voxels.shape != label_map.voxels.shape or not same_place:
        raise BadInput(
            f"grids of {ct.voxels.shape} and {label_map.voxels.shape} voxels",
            "CT and label map lie on one grid",
            "bring one of them to the grid of the other",
        )
    lung_ml, effusion_ml = _volume_ml(label_map, name), _volume_ml(label_map, "effusion")
    if lung_ml < parameters.smallest_lung_ml:
        raise BadInput(
            f"{lung_ml:.0f} ml with the label {name}",
            f"the lung that collapses has at least {parameters.smallest_lung_ml:g} ml",
            "choose the other side, mend the label map, or lower smallest_lung_ml",
        )
    if effusion_ml > parameters.largest_effusion_ml or CAVITY in label_map.names:
        raise BadInput(
            f"{effusion_ml:.0f} ml with the label effusion"
            if CAVITY not in label_map.names
            else f"a label map with {CAVITY}",
            "a collapse is simulated in a chest with healthy lungs"
            f" (effusion up to {parameters.largest_effusion_ml:g} ml)",
            "use this scan as it is, or mend the label map",
        )


def _volume_ml(label_map: LabelMap, name: str) -> float:
    if name not in label_map.names:
        return 0.0
    count = np.count_nonzero(label_map.mask(name))
    return count * voxel_volume_mm3(label_map.patient_from_index) / ML_IN_MM3


def _moved(
    patient_from_index: Float[np.ndarray, "4 4"], box: tuple[slice, slice, slice]
) -> Float[np.ndarray, "4 4"]:
    """Return the transform of a part of a grid."""
    start = np.array([[side.start for side in box]], float)
    moved = patient_from_index.copy()
    moved[:3, 3] = transform_points(patient_from_index, start)[0]
    return moved


def _places(label_map: LabelMap, name: str) -> Float[np.ndarray, "n 3"]:
    if name not in label_map.names:
        return np.empty((0, 3))
    places = np.argwhere(label_map.mask(name)).astype(float)
    return transform_points(label_map.patient_from_index, places)


def _tissue(label_map: LabelMap) -> Mask:
    """Return what is neither air nor lung: where the noise is measured, and the wall."""
    solid = [n + 1 for n, name in enumerate(label_map.names) if name in ("body", "bone")]
    return np.isin(label_map.voxels, solid)


def _relabelled(
    label_map: LabelMap, name: str, box: tuple[slice, slice, slice], parts: Parts, strands: Mask
) -> LabelMap:
    names = (*label_map.names, CAVITY)
    names = names if ADHESION in names else (*names, ADHESION)
    labels: UInt8[np.ndarray, "i j k"] = label_map.voxels.copy()
    view = labels[box]
    view[parts.lung] = names.index(name) + 1
    view[parts.cavity] = names.index(CAVITY) + 1
    view[strands] = names.index(ADHESION) + 1
    return replace(label_map, voxels=labels, names=names)


def _origin(
    ct: Origin, labels: Origin, name: str, made: LabelMap, count: int,
    parameters: CollapseLungParameters,
) -> Origin:  # fmt: skip
    """Return the CT's origin, with all that a reader must know about the simulation."""
    cavity = made.mask(CAVITY)
    pieces = len(connected_parts(cavity[bounding_box(cavity)])[1])
    told = [
        f'the collapse of "{name}" is simulated: in the CT it was healthy;'
        f' "{CAVITY}" ({_volume_ml(made, CAVITY):.0f} ml, filled with {parameters.filling}),'
        f' "{ADHESION}" and the collapsed lung are made up',
        f"of the old lung's volume {parameters.collapsed_share:.0%} became cavity; the lung lies"
        f" {parameters.lung_lies}; {count} adhesions, seed {parameters.seed}",
        f'the bronchi of "{name}" count as lung: "airway" ends at its hilum',
    ]
    if pieces > 1:
        told.append(f'"{CAVITY}" is in {pieces} pieces: adhesions cut it')
    if count < parameters.adhesions:
        told.append(f"{count} of {parameters.adhesions} adhesions: there is room for no more")
    source = f"{ct.source}, {name.replace('_', ' ')} collapsed by simulation"
    origin = replace(ct, source=source, simulated=True)
    return origin.with_notice(*labels.notices, *told)
