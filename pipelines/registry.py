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
    pleuroscopy,
    pleuroscopy_collapsed,
    pleuroscopy_phantom,
    study_crisp_collapsed,
    study_crisp_phantom,
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
    "pleuroscopy": pleuroscopy,
    "pleuroscopy_collapsed": pleuroscopy_collapsed,
    "pleuroscopy_phantom": pleuroscopy_phantom,
    "study_crisp_collapsed": study_crisp_collapsed,
    "study_crisp_phantom": study_crisp_phantom,
}
