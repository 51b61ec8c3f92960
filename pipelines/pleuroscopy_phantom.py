"""Pleuroscopy in a phantom with an effusion, whose anatomy is known: runs anywhere."""

from pipelines import pleuroscopy
from pipelines.stage import Stage

STAGES = [Stage("imaging.make_thorax_phantom", [], ["ct_files", "truth"]), *pleuroscopy.STAGES]
