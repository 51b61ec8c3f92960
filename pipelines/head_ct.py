"""From a head CT to skin and bone, surfaces, and a page."""

from pipelines import anatomy
from pipelines.stage import Stage

STAGES = [
    *anatomy.READ[:-1],
    Stage("imaging.segment_ct", ["ct", "given_labels"], ["label_map"], "segment_head_ct"),
    *anatomy.SURFACES,
    *anatomy.SHOW[:3],
    Stage("reporting.build_case_page", [*anatomy.SECTIONS[:3], "run_account"], ["page"]),
]
