"""What reconstruction starts from."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8

from nodes.geometry.arrays import freeze_arrays


@dataclass(frozen=True)
class Frames:
    """Pictures of one endoscope in the order of their files' names.

    Parameters
    ----------
    pixels : (frame, row, column, 3) red, green, blue.
    skipped : number of pictures of another kind in the same folder, such as a mask.
    """

    pixels: UInt8[np.ndarray, "frames rows columns 3"]
    skipped: int = 0

    def __post_init__(self) -> None:
        freeze_arrays(self)
