"""3D Slicer's markups (.mrk.json): named control points in a coordinate system that the file names.

The keys: slicer.readthedocs.io, Developer Guide, Markups. Orientations are written, so that 3D
Slicer can show a pose, but not read: 3D Slicer writes one for each point, and mostly an arbitrary
one.
"""

import json
from typing import Any

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.geometry.sites import Sites

LPS_FROM_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
# A name and the 4 x 4 pose or the 3 coordinates of a point.
Site = tuple[str, Float[np.ndarray, "..."]]
SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups"
    "/Resources/Schema/markups-schema-v1.0.3.json#"
)


def write_markups(value: Sites) -> dict[str, Any]:
    """Return a point list as 3D Slicer has it, with the axes of poses."""
    axes = [*value.patient_from_site[:, :3, :3], *[np.eye(3)] * len(value.point_names)]
    return {
        "@schema": SCHEMA,
        "markups": [
            {
                "type": "Fiducial",
                "coordinateSystem": "LPS",
                "coordinateUnits": "mm",
                "controlPoints": [
                    {
                        "label": name,
                        "position": place.tolist(),
                        "orientation": rotation.ravel().tolist(),
                        "positionStatus": "defined",
                    }
                    for name, place, rotation in zip(
                        value.names, value.places_patient_mm, axes, strict=True
                    )
                ],
            }
        ],
    }


def read_markups(name: str, text: str) -> list[Site]:
    """Return all defined control points of all markups in a file, as points in patient LPS mm.

    Parameters
    ----------
    name : of the file; points without a label are called by it and a number.
    text : of the file.

    Raises
    ------
    BadInput for text that is no markups file, another coordinate system or unit, and odd numbers.
    """
    try:
        markups = json.loads(text)["markups"]
        found = [
            (markup["coordinateSystem"], markup.get("coordinateUnits", "mm"), point)
            for markup in markups
            for point in markup["controlPoints"]
            if point.get("positionStatus", "defined") == "defined"
        ]
        return [_control_point(name, number, *each) for number, each in enumerate(found, start=1)]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(
            f"site {name}: no markups with coordinateSystem and controlPoints",
            "a .mrk.json file is as 3D Slicer saves it",
            "save the markups again",
        ) from None


def _control_point(name: str, number: int, system: str, units: Any, point: dict) -> Site:
    label = point.get("label") or f"{name}_{number}"
    if system not in ("LPS", "RAS") or units not in ("mm", ["mm", "mm", "mm"]):
        raise BadInput(
            f"site {label}: coordinates in {system}, {units}",
            "markups are in LPS or RAS, in mm",
            "save the markups again in one of them",
        )
    place = read_numbers(label, point["position"])
    if len(place) != 3:
        raise BadInput(
            f"site {label}: {len(place)} coordinates", "a point has 3", "correct the position"
        )
    return label, LPS_FROM_RAS[:3, :3] @ place if system == "RAS" else place


def read_numbers(name: str, words: list[Any]) -> Float[np.ndarray, " n"]:
    """Return finite numbers; what is none is not quoted, since other text may name a patient."""
    for place, word in enumerate(words, start=1):
        try:
            found = "" if np.isfinite(float(word)) and not isinstance(word, bool) else str(word)
        except (TypeError, ValueError):
            found = "no number"
        if found:
            raise BadInput(
                f"site {name}: entry {place} of {len(words)} is {found}",
                "a site is made of finite numbers, mm",
                "correct it, or take the file out if it is no site",
            )
    return np.array([float(word) for word in words])
