"""From a CT to labelled anatomy, an occupancy grid, surfaces, and a page that shows them."""

from pipelines.stage import Stage

STAGES = [
    Stage("imaging.read_volume", {"image_files": "ct_files"}, ["ct"]),
    Stage("imaging.segment_ct", ["ct"], ["label_map"]),
    Stage("imaging.measure_labels", ["label_map"], ["label_table"]),
    Stage("environment.build_occupancy_grid", ["label_map"], ["occupancy_grid"]),
    Stage("environment.build_surfaces", ["label_map"], ["surfaces"]),
    Stage("reporting.show_surfaces", ["surfaces"], ["surfaces_section"]),
    Stage("reporting.show_slices", {"volume": "ct", "label_map": "label_map"}, ["slices_section"]),
    Stage("reporting.show_table", {"table": "label_table"}, ["measures_section"], "show_measures"),
    Stage(
        "reporting.build_case_page",
        ["surfaces_section", "slices_section", "measures_section", "run_account"],
        ["page"],
    ),
]
