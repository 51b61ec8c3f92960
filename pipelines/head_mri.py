"""From a head MRI to the brain's halves, ventricles and skull, space for a robot, and a page."""

from pipelines import anatomy
from pipelines.stage import Stage

STAGES = [
    Stage("imaging.read_volume", {"image_files": "mri_files"}, ["mri"], "read_mri"),
    Stage(
        "imaging.place_labels", {"label_files": "label_files", "volume": "mri"}, ["given_labels"]
    ),
    Stage("imaging.segment_mri", ["mri", "given_labels"], ["label_map"]),
    Stage(
        "environment.build_occupancy_grid",
        ["label_map"],
        ["occupancy_grid", "parts_table"],
        "build_brain_grid",
    ),
    *anatomy.SURFACES,
    Stage("environment.measure_distance", ["occupancy_grid"], ["distance_field"]),
    Stage("reporting.show_surfaces", ["surfaces"], ["surfaces_section"]),
    Stage("reporting.show_slices", {"volume": "mri", "label_map": "label_map"}, ["slices_section"]),
    Stage("reporting.show_table", {"table": "label_table"}, ["measures_section"], "show_measures"),
    Stage("reporting.build_case_page", [*anatomy.SECTIONS[:3], "run_account"], ["page"]),
]
