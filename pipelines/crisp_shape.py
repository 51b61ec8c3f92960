"""From a CRISP set-up and a configuration to its shape and a page."""

from pipelines.stage import Stage

PAGE = [
    Stage("reporting.show_shape", ["robot_shape"], ["shape_section"]),
    Stage("reporting.build_case_page", ["shape_section", "run_account"], ["page"]),
]

STAGES = [
    Stage("mechanics.shape_crisp", ["crisp_setup", "crisp_configuration"], ["robot_shape"]),
    *PAGE,
]
