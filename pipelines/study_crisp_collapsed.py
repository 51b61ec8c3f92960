"""The tables of Kuntz 2017 beside ours, beside a lung that is collapsed by simulation."""

from pipelines import pleuroscopy_collapsed, study_crisp
from pipelines.pleuroscopy import CHOOSE

_PATIENT = pleuroscopy_collapsed.STAGES

STAGES = [*_PATIENT[: _PATIENT.index(CHOOSE[0])], *study_crisp.STUDY]
