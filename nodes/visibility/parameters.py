"""Parameters of visibility, one class a node."""

from nodes.geometry.lines_of_sight import Reading
from nodes.parameters import Parameters


class FindVisibilitySetsParameters(Parameters):
    """When a cell counts as seen; the field of view is the set-up's."""

    reading: Reading
    """Whether a cell is seen if its own ray is free ([Kuntz2017] Sec. IV-A), or if it is the first
    obstacle cell on the ray to any cell in the field of view (Sec. IV-C); no unit."""
