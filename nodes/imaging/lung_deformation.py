"""How a lung lies that has collapsed: drawn towards its hilum and one wall of its cavity.

The map from the healthy lung to the collapsed one is affine about an anchor, which lies at the
hilum's height on the wall that the lung falls to. All is done in patient mm.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from nodes.geometry.frames import transform_points
from nodes.geometry.grids import spacing_mm
from nodes.geometry.masks import Mask, bounding_box
from nodes.imaging.parameters import CollapseLungParameters

Affine = Float[np.ndarray, "4 4"]
Vector = Float[np.ndarray, "3"]
Box = tuple[slice, slice, slice]

DIRECTIONS = {"posterior": (0.0, 1.0, 0.0), "anterior": (0.0, -1.0, 0.0), "medial": None}
COARSE_MM = 3.0  # of the grid on which sizes are found and surfaces smoothed
SMALLEST, LARGEST = 0.05, 1.5  # scales
BISECTIONS = 16  # to 1 part in 65,000


@dataclass(frozen=True)
class Region:
    """A lung on a coarse grid of patient mm, and its landmarks.

    Parameters
    ----------
    share : (i, j, k) share of each coarse voxel that is lung, 0 to 1, smoothed.
    inside : (i, j, k) where it is lung, not smoothed.
    patient_from_coarse : (4, 4) coarse indices to patient LPS mm.
    """

    share: Float32[np.ndarray, "i j k"]
    inside: Mask
    patient_from_coarse: Affine

    @property
    def places_patient_mm(self) -> Float[np.ndarray, "n 3"]:
        """Centres of the coarse voxels that are lung, mm."""
        return transform_points(self.patient_from_coarse, np.argwhere(self.inside).astype(float))


def coarsen(lung: Mask, patient_from_index: Affine, smoothing_mm: float) -> Region:
    """Average a mask over blocks of about `COARSE_MM`, and smooth it (Gaussian)."""
    from scipy import ndimage

    box = bounding_box(lung)
    cubes = np.maximum(np.rint(COARSE_MM / spacing_mm(patient_from_index)).astype(int), 1)
    margin = 2 + int(np.ceil(3 * smoothing_mm / COARSE_MM))
    part = lung[box]
    wanted = (-(-np.array(part.shape) // cubes) + 2 * margin) * cubes
    before = margin * cubes
    after = wanted - before - part.shape
    padded = np.pad(part, np.stack([before, after], axis=1))
    blocks = (wanted // cubes)[:, None] * [1, 0] + cubes[:, None] * [0, 1]
    share = padded.reshape(blocks.ravel()).mean(axis=(1, 3, 5), dtype=np.float32)
    patient_from_coarse = patient_from_index @ _index_from_coarse(box, before, cubes)
    widths = smoothing_mm / spacing_mm(patient_from_coarse)
    return Region(ndimage.gaussian_filter(share, widths), share >= 0.5, patient_from_coarse)


def _index_from_coarse(box: Box, before: np.ndarray, cubes: np.ndarray) -> Affine:
    transform = np.diag([*cubes.astype(float), 1.0])
    transform[:3, 3] = [side.start for side in box] - before + (cubes - 1) / 2
    return transform


def find_hilum(region: Region, airway_patient_mm: Float[np.ndarray, "n 3"], side: int) -> Vector:
    """Return where bronchus and vessels enter the lung (side: 1 left, -1 right).

    Where there is an airway, the main bronchus is what lies beside the trachea's line; the hilum is
    the lung's nearest place to it. Else it is the inner side at the lung's middle.
    """
    inside = region.places_patient_mm
    middle = inside.mean(axis=0)
    bronchus = _main_bronchus(airway_patient_mm, side)
    if bronchus is None:
        inner = side * np.quantile(side * inside[:, 0], 0.02)
        bronchus = np.array([inner, middle[1], middle[2]])
    return inside[np.argmin(((inside - bronchus) ** 2).sum(axis=1))]


def _main_bronchus(airway_patient_mm: Float[np.ndarray, "n 3"], side: int) -> Vector | None:
    """Return the middle of the airway's parts next to the trachea's line, on one side."""
    if len(airway_patient_mm) == 0:
        return None
    top = np.quantile(airway_patient_mm[:, 2], 0.8)
    trachea_x = np.median(airway_patient_mm[airway_patient_mm[:, 2] >= top, 0])
    lateral = side * (airway_patient_mm[:, 0] - trachea_x)
    main = airway_patient_mm[(lateral > 15) & (lateral < 35)]
    return np.median(main, axis=0) if len(main) else None


def find_anchor(region: Region, hilum: Vector, direction: str) -> Vector:
    """Return the place on the cavity's wall that lies in a direction from the hilum."""
    toward = DIRECTIONS[direction]
    if toward is None:
        return hilum
    offset = region.places_patient_mm - hilum
    along = offset @ np.array(toward)
    across = np.linalg.norm(offset - along[:, None] * toward, axis=1)
    return hilum + max(along[across < 20].max(), 0.0) * np.array(toward)


def collapsed_from_healthy(
    anchor: Vector, scale: float, direction: str, flattening: float
) -> Affine:
    """Return the map that draws a lung to its anchor, to `scale`^3 of its volume.

    Along the direction it is drawn in `flattening` times as much (as a power) as across it.
    """
    powers = np.ones(3)
    toward = DIRECTIONS[direction]
    if toward is not None:
        powers += (flattening - 1) * abs(np.array(toward))
    factors = scale ** (powers * 3 / powers.sum())
    transform = np.diag([*factors, 1.0])
    transform[:3, 3] = anchor - factors * anchor
    return transform


@dataclass(frozen=True)
class Collapse:
    """A collapse of one lung.

    Parameters
    ----------
    patient_from_healthy : (4, 4) places in the healthy lung to those in the collapsed one, mm.
    hilum_patient_mm : (3,) where the lung hangs on.
    stalk_radius_mm : of the tissue that joins the hilum to its place in the collapsed lung.
    """

    patient_from_healthy: Affine
    hilum_patient_mm: Vector
    stalk_radius_mm: float

    def belonging(
        self, region: Region, patient_from_index: Affine, shape: tuple[int, ...]
    ) -> Float32[np.ndarray, "i j k"]:
        """Return how much each voxel of a grid belongs to the collapsed lung: above 0.5 inside."""
        lung = self.moved(region.share, region.patient_from_coarse, patient_from_index, shape, 0.0)
        end = transform_points(self.patient_from_healthy, self.hilum_patient_mm[None])[0]
        reach = 2 * self.stalk_radius_mm
        window, away = around_segment(
            patient_from_index, shape, (self.hilum_patient_mm, end), reach
        )
        np.maximum(lung[window], 1 - away / np.float32(reach), out=lung[window])
        return lung

    def moved(
        self,
        values: Float32[np.ndarray, "_ _ _"],
        patient_from_values: Affine,
        patient_from_index: Affine,
        shape: tuple[int, ...],
        beyond: float,
    ) -> Float32[np.ndarray, "i j k"]:
        """Return values of the healthy lung where they come to lie on a grid, linearly resampled;
        `beyond` the edge of the image they were on."""
        from scipy import ndimage

        values_from_index = (
            np.linalg.inv(patient_from_values)
            @ np.linalg.inv(self.patient_from_healthy)
            @ patient_from_index
        )
        return ndimage.affine_transform(
            values, values_from_index, output_shape=shape, order=1, cval=beyond
        )


def around_segment(
    patient_from_index: Affine,
    shape: tuple[int, ...],
    ends: tuple[Vector, Vector],
    reach_mm: float,
) -> tuple[Box, Float32[np.ndarray, "i j k"]]:
    """Return the part of a grid around a straight segment, and its voxels' distances to it, mm."""
    start, end = ends
    places = transform_points(np.linalg.inv(patient_from_index), np.stack([start, end]))
    margin = reach_mm / spacing_mm(patient_from_index) + 1
    low = np.clip(np.floor(places.min(axis=0) - margin), 0, shape).astype(int)
    high = np.clip(np.ceil(places.max(axis=0) + margin) + 1, low, shape).astype(int)
    size = tuple(int(n) for n in high - low)
    index = np.indices(size).reshape(3, -1).T + low.astype(float)
    offset = transform_points(patient_from_index, index) - start
    along = end - start
    share = np.clip(offset @ along / max(along @ along, 1e-12), 0, 1)
    away = np.linalg.norm(offset - share[:, None] * along, axis=1)
    box = (slice(low[0], high[0]), slice(low[1], high[1]), slice(low[2], high[2]))
    return box, away.reshape(size).astype(np.float32)


def fit_collapse(region: Region, hilum: Vector, parameters: CollapseLungParameters) -> Collapse:
    """Return the collapse that leaves the wanted share of the cavity free, by bisection.

    What the map would push through the cavity's wall does not count, so the lung is drawn in less
    than its volume alone would ask for.
    """
    direction, wanted = parameters.lung_lies, 1 - parameters.collapsed_share
    anchor = find_anchor(region, hilum, direction)
    low, high = SMALLEST, LARGEST
    for _ in range(BISECTIONS):
        scale = (low + high) / 2
        transform = collapsed_from_healthy(anchor, scale, direction, parameters.flattening)
        collapse = Collapse(transform, hilum, parameters.stalk_radius_mm)
        belonging = collapse.belonging(region, region.patient_from_coarse, region.share.shape)
        filled = (belonging[region.inside] >= 0.5).mean()
        low, high = (low, scale) if filled > wanted else (scale, high)
    return collapse
