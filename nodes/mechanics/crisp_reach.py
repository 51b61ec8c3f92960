"""Where the snares of CRISP robots grasp as the tool is inserted, and whether they can reach."""

import numpy as np
from jaxtyping import Bool, Float

from nodes.errors import BadInput
from nodes.mechanics.crisp_arrays import to_grasps
from nodes.mechanics.robots import CrispSetup

Lengths = Float[np.ndarray, "*batch needle"]


def find_grasps(setup: CrispSetup, lengths_mm: Lengths) -> Float[np.ndarray, "*batch joint"]:
    """Return the arc length on the tool of each joint, mm; the joints in one order for all.

    Raises
    ------
    BadInput : if joints pass one another, or lie off the tool.
    """
    tools = np.unique(lengths_mm[..., 0])
    tool, slope = tools[0], 1.0
    near, far = to_grasps(setup, tool), to_grasps(setup, tools[-1])
    if not np.array_equal(near.snare, far.snare):
        raise BadInput(
            f"needles {near.snare} grasp in this order, later {far.snare}",
            "joints keep their order along the tool on one edge",
            "cut the edge where the joints pass one another",
        )
    slope = (far.arc - near.arc) / max(tools[-1] - tool, np.finfo(float).tiny)
    arcs = near.arc + slope * (lengths_mm[..., :1] - tool)
    if np.any(arcs < 0) or np.any(arcs > lengths_mm[..., :1] * (1 + 1e-12)):
        raise BadInput(
            f"grasps from {arcs.min():.2f} to {arcs.max():.2f} mm on a tool of {tool:.2f} mm",
            "snares grasp the tool between its entry point and its tip",
            "insert the tool further, or grasp nearer to its tip",
        )
    return arcs


def is_too_short(
    setup: CrispSetup, lengths_mm: Lengths, arcs_mm: Float[np.ndarray, "*batch joint"]
) -> Bool[np.ndarray, "*batch"]:
    """Return where needles cannot meet, since they are shorter than the straight way.

    From one entry point to another the way leads along a needle to its joint, along the tool to the
    next joint, and back along the other needle.
    """
    snares = to_grasps(setup, float(lengths_mm[..., 0].flat[0])).snare
    entries = setup.entry_points_patient_mm[np.concatenate([[0], snares])]
    arcs = np.concatenate([np.zeros_like(arcs_mm[..., :1]), arcs_mm], axis=-1)
    reach = np.concatenate([np.zeros_like(arcs_mm[..., :1]), lengths_mm[..., snares]], axis=-1)
    along = np.abs(arcs[..., :, None] - arcs[..., None, :])
    apart = np.linalg.norm(entries[:, None] - entries[None], axis=-1)
    longest = reach[..., :, None] + reach[..., None, :] + along
    return np.asarray(np.any(apart > longest, axis=(-1, -2)))
