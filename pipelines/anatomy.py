"""From a chest CT to labelled anatomy, the space for a robot, entries to it, and a page."""

from pipelines.stage import Stage

READ = [
    Stage("imaging.read_volume", {"image_files": "ct_files"}, ["ct"]),
    Stage("imaging.place_labels", {"label_files": "label_files", "volume": "ct"}, ["given_labels"]),
    Stage("imaging.segment_ct", ["ct", "given_labels"], ["label_map"]),
]
SURFACES = [
    Stage("environment.build_surfaces", ["label_map"], ["surfaces"]),
    Stage("environment.sample_point_cloud", ["surfaces"], ["point_cloud"]),
    Stage("environment.measure_labels", ["label_map", "surfaces"], ["label_table"]),
]
SPACE = [
    Stage("environment.measure_distance", ["occupancy_grid"], ["distance_field"]),
    Stage(
        "environment.find_entry_corridors",
        ["label_map", "occupancy_grid"],
        ["entry_map", "entry_table"],
    ),
]
SHOW = [
    Stage("reporting.show_surfaces", ["surfaces"], ["surfaces_section"]),
    Stage("reporting.show_slices", {"volume": "ct", "label_map": "label_map"}, ["slices_section"]),
    Stage("reporting.show_table", {"table": "label_table"}, ["measures_section"], "show_measures"),
    Stage("reporting.show_table", {"table": "parts_table"}, ["parts_section"], "show_parts"),
    Stage("reporting.show_entries", ["surfaces", "entry_map", "entry_table"], ["entries_section"]),
]
SECTIONS = (
    "surfaces_section",
    "slices_section",
    "measures_section",
    "entries_section",
    "parts_section",
)

STAGES = [
    *READ,
    Stage("environment.build_occupancy_grid", ["label_map"], ["occupancy_grid", "parts_table"]),
    *SURFACES,
    *SPACE,
    *SHOW,
    Stage("reporting.build_case_page", [*SECTIONS, "run_account"], ["page"]),
]
