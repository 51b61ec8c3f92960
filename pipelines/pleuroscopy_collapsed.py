"""Pleuroscopy beside a lung that is collapsed by simulation in the CT of healthy lungs."""

from pipelines import collapsed_lung, pleuroscopy

STAGES = [
    *collapsed_lung.COLLAPSE,
    *pleuroscopy.GRID[1:],
    *pleuroscopy.MEASURE,
    *pleuroscopy.CHOOSE,
    *pleuroscopy.PLAN,
    *pleuroscopy.REPORT,
]
