"""The anatomy pipeline on a phantom whose truth is known, so that its errors can be shown."""

from pipelines import anatomy
from pipelines.stage import Stage

STAGES = [
    Stage("imaging.make_thorax_phantom", [], ["ct_files", "truth"]),
    *anatomy.STAGES[:-1],
    Stage("imaging.score_segmentation", ["label_map", "truth"], ["score_table"]),
    Stage("reporting.show_table", {"table": "score_table"}, ["scores_section"], "show_scores"),
    Stage(
        "reporting.build_case_page",
        ["surfaces_section", "slices_section", "scores_section", "measures_section", "run_account"],
        ["page"],
    ),
]
