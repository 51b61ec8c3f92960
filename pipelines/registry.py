"""Every pipeline by name; a pipeline is a module with a plain list of stages."""

from pipelines import anatomy, thorax_phantom

PIPELINES = {"anatomy": anatomy, "thorax_phantom": thorax_phantom}
