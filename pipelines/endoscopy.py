"""From the frames of an endoscope to a page that shows them."""

from pipelines.stage import Stage

STAGES = [
    Stage("reporting.show_frames", ["frames"], ["frames_section"]),
    Stage("reporting.build_case_page", ["frames_section", "run_account"], ["page"]),
]
