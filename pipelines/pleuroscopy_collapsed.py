"""Pleuroscopy beside a lung that is collapsed by simulation in the CT of healthy lungs."""

from pipelines import collapsed_lung, pleuroscopy
from pipelines.stage import Stage

STAGES = [
    *collapsed_lung.COLLAPSE,
    Stage(
        "environment.build_occupancy_grid",
        ["label_map"],
        ["occupancy_grid", "parts_table"],
        "build_fine_cavity_grid",
    ),
    *pleuroscopy.GRID[1:],
    *pleuroscopy.MEASURE,
    *pleuroscopy.CHOOSE,
    *pleuroscopy.PLAN,
    *pleuroscopy.REPORT,
]
