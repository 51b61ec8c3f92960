"""From an MRI to a page that shows it in three planes."""

from pipelines.stage import Stage

STAGES = [
    Stage("imaging.read_volume", {"image_files": "mri_files"}, ["mri"], "read_mri"),
    Stage("reporting.show_volume", {"volume": "mri"}, ["slices_section"]),
    Stage("reporting.build_case_page", ["slices_section", "run_account"], ["page"]),
]
