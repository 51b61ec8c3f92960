"""Every pipeline by name; a pipeline is a module with a plain list of stages.

Where several take the same images, a new case gets the first.
"""

from pipelines import (
    anatomy,
    collapsed_lung,
    concentric_tube_shape,
    crisp_shape,
    endoscopy,
    head_ct,
    head_mri,
    label_maps,
    mri,
    thorax_phantom,
)

PIPELINES = {
    "thorax_phantom": thorax_phantom,
    "anatomy": anatomy,
    "collapsed_lung": collapsed_lung,
    "head_ct": head_ct,
    "head_mri": head_mri,
    "mri": mri,
    "label_maps": label_maps,
    "endoscopy": endoscopy,
    "concentric_tube_shape": concentric_tube_shape,
    "crisp_shape": crisp_shape,
}
