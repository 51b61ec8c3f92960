"""Arrays of artefacts are read-only: what a stage made, no later stage can change."""

from dataclasses import fields

import numpy as np


def freeze_arrays(artefact: object) -> None:
    """Replace each array field of a frozen dataclass by a C-contiguous read-only array.

    The caller's own array stays writable; a view is frozen, and copied only if it is not
    contiguous.
    """
    for field in fields(artefact):  # type: ignore[arg-type]
        value = getattr(artefact, field.name)
        if isinstance(value, np.ndarray):
            frozen = np.ascontiguousarray(value).view()
            frozen.flags.writeable = False
            object.__setattr__(artefact, field.name, frozen)
