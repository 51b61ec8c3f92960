"""Chains of circular arcs: poses along them [Yang2019] Sec. II-B.

An arc leaves the origin along +z in the plane of azimuth theta. Frames are carried along it without
twist, so that the next arc's azimuth is told in the frame Rz(theta) Ry(psi) Rz(-theta), psi being
the central angle; Table 1 of the paper comes out with this convention only.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays


@dataclass(frozen=True)
class Arcs:
    """Circular arcs, one or many; the last axis counts the sections of a chain from its base.

    Parameters
    ----------
    bending_plane_rad : (..., section) azimuth theta of the direction it bends to, rad; 0 where
        straight.
    curvature_per_mm : (..., section) gamma >= 0, 1/mm; 0 where straight.
    length_mm : (..., section) arc length, mm.
    """

    bending_plane_rad: Float[np.ndarray, "*chain section"]
    curvature_per_mm: Float[np.ndarray, "*chain section"]
    length_mm: Float[np.ndarray, "*chain section"]

    def __post_init__(self) -> None:
        freeze_arrays(self)

    @property
    def central_angle_rad(self) -> Float[np.ndarray, "*chain section"]:
        """psi = gamma l, [Yang2019] eq. (13), rad."""
        return self.curvature_per_mm * self.length_mm


def pose_arcs(arcs: Arcs) -> Float[np.ndarray, "*chain section 4 4"]:
    """Return the pose of each arc's end in the frame of its own start, [Yang2019] eq. (12).

    (1 - cos psi) / gamma is written as l (psi / 2) sinc^2(psi / 2), which holds all digits however
    straight the arc is.
    """
    psi, length = arcs.central_angle_rad, arcs.length_mm
    c, s = np.cos(arcs.bending_plane_rad), np.sin(arcs.bending_plane_rad)
    one_less = 2 * np.sin(psi / 2) ** 2  # 1 - cos psi
    aside = length * (psi / 2) * _sinc(psi / 2) ** 2
    sine, cosine, zero = np.sin(psi), np.cos(psi), np.zeros_like(psi)
    rows = [
        [1 - c * c * one_less, -s * c * one_less, c * sine, c * aside],
        [-s * c * one_less, 1 - s * s * one_less, s * sine, s * aside],
        [-c * sine, -s * sine, cosine, length * _sinc(psi)],
        [zero, zero, zero, zero + 1],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def pose_chain(arcs: Arcs) -> Float[np.ndarray, "*chain section 4 4"]:
    """Return the pose of each section's end in the chain's base frame, [Yang2019] eq. (14)."""
    poses = pose_arcs(arcs)
    for section in range(1, poses.shape[-3]):
        poses[..., section, :, :] = poses[..., section - 1, :, :] @ poses[..., section, :, :]
    return poses


def sample_chain(
    arcs: Arcs, arc_lengths_mm: Float[np.ndarray, "points"]
) -> Float[np.ndarray, "points 4 4"]:
    """Return the poses at given places along one chain.

    Parameters
    ----------
    arcs : of one chain, (section,).
    arc_lengths_mm : (points,) from the base, mm; beyond the tip counts as the tip.
    """
    starts = np.concatenate([[0.0], np.cumsum(arcs.length_mm)[:-1]])
    section = np.searchsorted(starts, arc_lengths_mm, side="right") - 1
    section = np.clip(section, 0, len(starts) - 1)
    within = np.clip(arc_lengths_mm - starts[section], 0.0, arcs.length_mm[section])
    parts = Arcs(arcs.bending_plane_rad[section], arcs.curvature_per_mm[section], within)
    bases = np.concatenate([np.eye(4)[None], pose_chain(arcs)[:-1]])
    return bases[section] @ pose_arcs(parts)


def _sinc(angle: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
    """Return sin(angle) / angle, 1 at 0."""
    return np.sinc(angle / np.pi)
