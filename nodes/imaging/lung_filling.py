"""Values of a simulated collapse: denser lung, fluid or air around it, noise as in the CT.

Density over that of water is 1 + HU/1000, which holds for air and soft tissue.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32, Float64, Shaped

from nodes.geometry.masks import Mask
from nodes.imaging.lung_adhesions import Parts
from nodes.imaging.lung_deformation import Affine, Collapse
from nodes.imaging.lung_parts import Settled, axial_axis
from nodes.imaging.parameters import CollapseLungParameters

TISSUE_HU = 40.0  # of airless lung, and of blood: denser than this nothing becomes
AIR_HU = -1000.0
SOFT_HU = (0.0, 90.0)  # of muscle, blood and organs, where the noise is measured
CLEARLY = 3.0  # standard deviations of the noise that tell two values apart
NOISE_LAG = 4  # pixels; so far apart noise is hardly correlated with common kernels
FEWEST_PAIRS = 200  # of pixels, to know a slice's noise
MAD_TO_SD = 1.482602219  # median of absolute normal deviates to standard deviation
DENSEST = 60.0  # times as dense as before, more than from air to tissue


@dataclass(frozen=True)
class Scene:
    """The part of the CT around the lung.

    Parameters
    ----------
    voxels : (i, j, k) HU.
    tissue : (i, j, k) what is neither lung nor air.
    patient_from_index : (4, 4) its indices to patient LPS mm.
    """

    voxels: Shaped[np.ndarray, "i j k"]
    tissue: Mask
    patient_from_index: Affine


def fill(
    scene: Scene,
    parts: Parts,
    strands: Mask,
    settled: Settled,
    collapse: Collapse,
    parameters: CollapseLungParameters,
    chance: np.random.Generator,
) -> Shaped[np.ndarray, "i j k"]:
    """Return the values of the scene with the collapsed lung, its cavity and the strands."""
    old = parts.lung | parts.cavity
    filling_hu = parameters.fluid_hu if parameters.filling == "fluid" else AIR_HU
    axial = axial_axis(scene.patient_from_index)
    sds_hu, width = measure_noise(scene.voxels, _soft(scene), axial)
    noise = make_noise(scene.voxels.shape, sds_hu, width, axial, chance)
    values = scene.voxels.astype(np.float32)
    lung_hu = float(np.median(values[old]))
    rim = _rim(parts.cavity) & scene.tissue
    tissue_hu = TISSUE_HU - CLEARLY * float(sds_hu.mean())
    values[rim] = wet_rim(values[rim], (lung_hu, tissue_hu), filling_hu)
    around = np.where(strands[old], np.float32(TISSUE_HU), np.float32(filling_hu)) + noise[old]
    collapsed = _collapsed_values(scene, old, lung_hu, settled, collapse)
    values[old] = around + settled.share * (collapsed - around)
    if np.issubdtype(scene.voxels.dtype, np.integer):
        values = np.rint(values)
    return values.astype(scene.voxels.dtype)


def _soft(scene: Scene) -> Mask:
    """Return the inside of muscles, heart and other soft tissue, without fat and edges."""
    from scipy import ndimage

    mean = ndimage.uniform_filter(scene.voxels.astype(np.float32), 5)
    return scene.tissue & (mean > SOFT_HU[0]) & (mean < SOFT_HU[1])


def _rim(cavity: Mask) -> Mask:
    """Return the voxels next to the cavity and next to these: as far as its edge is blurred."""
    from scipy import ndimage

    return ndimage.binary_dilation(cavity, iterations=2) & ~cavity


def _collapsed_values(
    scene: Scene, old: Mask, lung_hu: float, settled: Settled, collapse: Collapse
) -> Float32[np.ndarray, " n"]:
    """Return the values of the old lung's voxels if they are collapsed lung: the healthy lung where
    they come from, pressed until it holds the mass of all of it."""
    healthy = np.where(old, scene.voxels, np.float32(lung_hu)).astype(np.float32)
    grid = scene.patient_from_index
    values = collapse.moved(healthy, grid, grid, healthy.shape, lung_hu)[old]
    return condense(values, settled.share, mass_of(scene.voxels[old]))


def condense(
    values_hu: Float32[np.ndarray, " n"], shares: Float32[np.ndarray, " n"], mass: float
) -> Float32[np.ndarray, " n"]:
    """Press air out of lung until it holds a given mass: the sum of density times share.

    Every density grows by one factor, but not above that of tissue: blood and tissue cannot be
    pressed. Where even airless lung holds less, it becomes airless.
    """
    density = np.clip(values_hu - np.float32(AIR_HU), 0, None) / np.float32(1000)
    most = np.maximum(density, np.float32((TISSUE_HU - AIR_HU) / 1000))
    low, high = 0.0, DENSEST
    for _ in range(24):
        factor = (low + high) / 2
        pressed = np.minimum(density * np.float32(factor), most)
        low, high = (factor, high) if float(pressed @ shares) < mass else (low, factor)
    return pressed * np.float32(1000) + np.float32(AIR_HU)


def mass_of(values_hu: Shaped[np.ndarray, " n"]) -> float:
    """Return the sum of density over voxels; values below air's count as air."""
    return float(np.clip(values_hu - AIR_HU, 0, None).sum(dtype=float) / 1000)


def measure_noise(
    voxels: Shaped[np.ndarray, "i j k"], tissue: Mask, axial: int
) -> tuple[Float64[np.ndarray, " n"], float]:
    """Return the noise's standard deviation in each axial slice, HU, and its width, pixels.

    From differences between pixels of tissue a few pixels apart, whose variance is twice that of
    uncorrelated noise; the median is blind to the few that cross an edge. White noise that was
    blurred by a normal distribution of width s correlates by exp(-1 / (4 s^2)) from one pixel to
    the next, which gives s.
    """
    planes = zip(np.moveaxis(voxels, axial, 0), np.moveaxis(tissue, axial, 0), strict=True)
    variances = np.array([_variances_of_differences(*plane) for plane in planes])
    known = np.isfinite(variances).all(axis=1) & (variances[:, 1] > 0)
    if not known.any():
        return np.zeros(len(variances)), 0.0
    near, far = np.median(variances[known], axis=0)
    number = np.arange(len(variances))
    slices = np.interp(number, number[known], np.sqrt(variances[known, 1] / 2))
    correlation = 1 - near / far
    width = 0.5 / np.sqrt(-np.log(correlation)) if 0.02 < correlation < 0.98 else 0.0
    return slices, float(width)


def _variances_of_differences(
    plane: Shaped[np.ndarray, "i j"], tissue: Bool[np.ndarray, "i j"]
) -> tuple[float, float]:
    """Return the variance of differences between neighbours, and between pixels farther apart."""
    near = np.concatenate(
        [_differences(a, m, 1) for a, m in ((plane, tissue), (plane.T, tissue.T))]
    )
    far = np.concatenate(
        [_differences(a, m, NOISE_LAG) for a, m in ((plane, tissue), (plane.T, tissue.T))]
    )
    if len(far) < FEWEST_PAIRS:
        return np.nan, np.nan
    spread = [MAD_TO_SD * float(np.median(abs(found))) for found in (near, far)]
    return spread[0] ** 2, spread[1] ** 2


def _differences(
    plane: Shaped[np.ndarray, "i j"], tissue: Bool[np.ndarray, "i j"], lag: int
) -> Float32[np.ndarray, " n"]:
    both = tissue[lag:] & tissue[:-lag]
    values = plane.astype(np.float32)
    return values[lag:][both] - values[:-lag][both]


def make_noise(
    shape: tuple[int, int, int],
    sds_hu: Float64[np.ndarray, " n"],
    width: float,
    axial: int,
    chance: np.random.Generator,
) -> Float32[np.ndarray, "i j k"]:
    """Return noise with a spread for each axial slice, correlated within it over this width."""
    from scipy import ndimage

    noise = chance.standard_normal(shape, dtype=np.float32)
    if width > 0:
        noise = ndimage.gaussian_filter(
            noise, [0.0 if axis == axial else width for axis in range(3)], mode="wrap"
        )
        noise /= max(float(noise.std()), 1e-6)
    return noise * np.expand_dims(sds_hu.astype(np.float32), [a for a in range(3) if a != axial])


def wet_rim(
    values_hu: Float32[np.ndarray, " n"], range_hu: tuple[float, float], filling_hu: float
) -> Float32[np.ndarray, " n"]:
    """Return the values of edge voxels outside the lung, the lung in them replaced by filling.

    What is darker than tissue there (the range's upper end) is taken as part tissue and part lung
    (its lower end); fat cannot be told apart.
    """
    lung_hu, tissue_hu = range_hu
    share = np.clip((TISSUE_HU - values_hu) / np.float32(TISSUE_HU - lung_hu), 0, 1)
    share = np.where(values_hu < tissue_hu, share, np.float32(0))
    return values_hu + share * np.float32(filling_hu - lung_hu)
