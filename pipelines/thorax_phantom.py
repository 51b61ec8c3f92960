"""The anatomy pipeline on a phantom whose truth is known, so that its errors can be shown."""

from pipelines import anatomy
from pipelines.stage import Stage

# The robot moves in the fluid around the collapsed lung, not in the lungs.
EFFUSION = Stage(
    "environment.build_occupancy_grid",
    ["label_map"],
    ["occupancy_grid", "parts_table"],
    "build_effusion_grid",
)

STAGES = [
    Stage("imaging.make_thorax_phantom", [], ["ct_files", "truth"]),
    *anatomy.READ,
    EFFUSION,
    *anatomy.SURFACES,
    *anatomy.SPACE,
    Stage("imaging.score_segmentation", ["label_map", "truth"], ["score_table"]),
    *anatomy.SHOW,
    Stage("reporting.show_table", {"table": "score_table"}, ["scores_section"], "show_scores"),
    Stage(
        "reporting.build_case_page",
        [*anatomy.SECTIONS[:2], "scores_section", *anatomy.SECTIONS[2:], "run_account"],
        ["page"],
    ),
]
