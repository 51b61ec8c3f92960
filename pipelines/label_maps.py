"""From label maps drawn elsewhere, with start poses and targets, to an anatomy and a page."""

from pipelines import anatomy
from pipelines.stage import Stage

STAGES = [
    Stage("imaging.combine_label_maps", ["label_files"], ["label_map"]),
    Stage("imaging.check_sites", ["label_map", "sites"], ["site_table"]),
    Stage("environment.build_occupancy_grid", ["label_map"], ["occupancy_grid", "parts_table"]),
    *anatomy.SURFACES,
    Stage("environment.measure_distance", ["occupancy_grid"], ["distance_field"]),
    Stage("reporting.show_sites", ["surfaces", "sites"], ["surfaces_section"]),
    Stage("reporting.show_labels", ["label_map"], ["slices_section"]),
    Stage("reporting.show_table", {"table": "site_table"}, ["sites_section"], "show_site_table"),
    Stage("reporting.show_table", {"table": "label_table"}, ["measures_section"], "show_measures"),
    Stage(
        "reporting.build_case_page",
        [*anatomy.SECTIONS[:2], "sites_section", "measures_section", "run_account"],
        ["page"],
    ),
]
