"""From the CT of an effusion to checked plans of a CRISP robot, what its camera sees, and a page.

Its variants begin with a phantom (`pleuroscopy_phantom`) or with a lung that is collapsed by
simulation (`pleuroscopy_collapsed`); all then go the same way.
"""

from pipelines import anatomy
from pipelines.stage import Stage

CHOOSE = [
    Stage("planning.place_goals", ["sites", "label_map", "occupancy_grid"], ["goals"]),
    Stage(
        "planning.search_crisp_setups",
        ["given_setups", "entry_table", "label_map", "occupancy_grid", "distance_field", "goals"],
        ["placed_setups", "setup_table"],
    ),
]
PLAN = [
    Stage(
        "planning.grow_crisp_trees",
        ["placed_setups", "occupancy_grid", "distance_field", "label_map", "goals"],
        ["crisp_trees"],
    ),
    Stage(
        "visibility.find_visibility_sets",
        ["crisp_trees", "occupancy_grid"],
        ["visibility_sets", "visibility_table"],
    ),
    Stage(
        "planning.plan_crisp_motions",
        ["crisp_trees", "occupancy_grid", "distance_field", "label_map", "goals"],
        ["motion_plans"],
    ),
    Stage(
        "planning.check_crisp_plans",
        ["motion_plans", "goals", "occupancy_grid", "label_map"],
        ["checked_plans", "plan_table"],
    ),
]
SHOW = [
    Stage(
        "reporting.show_plans",
        ["checked_plans", "distance_field", "surfaces"],
        ["plans_section"],
    ),
    Stage(
        "reporting.show_visibility",
        ["visibility_sets", "crisp_trees", "distance_field", "visibility_table"],
        ["visibility_section"],
    ),
    Stage(
        "reporting.show_setups",
        ["crisp_trees", "setup_table", "surfaces"],
        ["setups_section"],
    ),
]
SECTIONS = ("plans_section", "visibility_section", "setups_section")

GRID = [
    Stage(
        "environment.build_occupancy_grid",
        ["label_map"],
        ["occupancy_grid", "parts_table"],
        "build_fine_effusion_grid",
    ),
    Stage("environment.build_surfaces", ["label_map"], ["surfaces"]),
    *anatomy.SPACE,
]
REPORT = [
    *SHOW,
    *anatomy.SHOW,
    Stage("reporting.build_case_page", [*SECTIONS, *anatomy.SECTIONS, "run_account"], ["page"]),
]
MEASURE = [Stage("environment.measure_labels", ["label_map", "surfaces"], ["label_table"])]

STAGES = [*anatomy.READ, *GRID, *MEASURE, *CHOOSE, *PLAN, *REPORT]
