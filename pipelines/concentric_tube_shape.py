"""From a concentric tube robot and its joint values to its shape and a page."""

from pipelines.crisp_shape import PAGE
from pipelines.stage import Stage

STAGES = [
    Stage(
        "mechanics.shape_concentric_tubes",
        ["concentric_tube_robot", "concentric_tube_configuration"],
        ["robot_shape"],
    ),
    *PAGE,
]
