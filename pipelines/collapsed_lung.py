"""The anatomy pipeline with one lung collapsed by simulation, for trials without an effusion."""

from pipelines import anatomy
from pipelines.stage import Stage

COLLAPSE = [
    Stage("imaging.read_volume", {"image_files": "ct_files"}, ["scanned_ct"]),
    Stage(
        "imaging.place_labels",
        {"label_files": "label_files", "volume": "scanned_ct"},
        ["given_labels"],
    ),
    Stage(
        "imaging.segment_ct",
        {"ct": "scanned_ct", "given_labels": "given_labels"},
        ["scanned_label_map"],
    ),
    Stage(
        "imaging.collapse_lung",
        {"ct": "scanned_ct", "label_map": "scanned_label_map"},
        ["ct", "label_map"],
    ),
]

STAGES = [
    *COLLAPSE,
    Stage(
        "environment.build_occupancy_grid",
        ["label_map"],
        ["occupancy_grid", "parts_table"],
        "build_cavity_grid",
    ),
    *anatomy.SURFACES,
    *anatomy.SPACE,
    *anatomy.SHOW,
    anatomy.STAGES[-1],
]
