"""The tables of Kuntz 2017 beside ours: set-ups side by side, seeded and not, at equal time."""

from pipelines import pleuroscopy
from pipelines.stage import Stage

STUDY = [
    *pleuroscopy.CHOOSE,
    Stage(
        "planning.grow_study_trees",
        ["placed_setups", "occupancy_grid", "distance_field", "label_map"],
        ["crisp_trees", "seeding_table"],
    ),
    Stage(
        "visibility.find_visibility_sets",
        ["crisp_trees", "occupancy_grid"],
        ["visibility_sets", "visibility_table"],
    ),
    Stage("visibility.tabulate_study", ["seeding_table", "visibility_sets"], ["study_table"]),
    Stage(
        "reporting.show_study",
        ["study_table", "visibility_sets", "crisp_trees"],
        ["study_section"],
    ),
    *pleuroscopy.SHOW[1:],
    Stage(
        "reporting.build_case_page",
        ["study_section", *pleuroscopy.SECTIONS[1:], "run_account"],
        ["page"],
    ),
]
