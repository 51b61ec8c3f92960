"""The tables of Kuntz 2017 beside ours, in a phantom with an effusion."""

from pipelines import pleuroscopy_phantom, study_crisp
from pipelines.pleuroscopy import CHOOSE

_PATIENT = pleuroscopy_phantom.STAGES

STAGES = [*_PATIENT[: _PATIENT.index(CHOOSE[0])], *study_crisp.STUDY]
