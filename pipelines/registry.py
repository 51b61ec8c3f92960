"""Every pipeline by name; a pipeline is a module with a plain list of stages."""

from pipelines import anatomy, endoscopy, mri, thorax_phantom

PIPELINES = {
    "thorax_phantom": thorax_phantom,
    "anatomy": anatomy,
    "mri": mri,
    "endoscopy": endoscopy,
}
