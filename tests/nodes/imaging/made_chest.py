"""A chest of cylinders on coarse voxels, with noise, whose every label is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.segment_ct import segment_ct

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters"
NAMES = ("body", "bone", "left_lung", "right_lung", "airway", "effusion")
BODY, BONE, LEFT_LUNG, RIGHT_LUNG, AIRWAY, EFFUSION = range(1, 7)
NONE_GIVEN = LabelMap(np.zeros((1, 1, 1), np.uint8), np.eye(4), (), Origin("nothing"))


def parameters(stage="segment_ct", **changed) -> SegmentCtParameters:
    values = yaml.safe_load((DEFAULTS / f"{stage}.yml").read_text())
    return SegmentCtParameters(**{**values, **changed})


def segmented(chest, given=NONE_GIVEN, stage="segment_ct", **changed) -> LabelMap:
    return segment_ct(chest.ct, given, parameters(stage, **changed))


def dice(one, other) -> float:
    return 2 * (one & other).sum() / (one.sum() + other.sum())


class Chest:
    """Draws solids by their voxels' centres, in patient LPS mm."""

    def __init__(self, step=3.0, noise=10.0, fluid_behind=None, lung_hu=-850):
        x, y, z = (
            np.arange(-half + step / 2, half, step, dtype=np.float32) for half in (150, 105, 105)
        )
        self.x, self.y, self.z = x[:, None, None], y[None, :, None], z[None, None, :]
        shape = (len(x), len(y), len(z))
        self.hu = np.full(shape, -1000, np.float32)
        self.labels = np.zeros(shape, np.uint8)
        self.noise = noise
        self.patient_from_index = np.diag([step, step, step, 1.0])
        self.patient_from_index[:3, 3] = [x[0], y[0], z[0]]
        self._draw(fluid_behind, lung_hu)

    def draw(self, where, hu, label):
        where = np.broadcast_to(where, self.hu.shape)
        self.hu[where], self.labels[where] = hu, label

    def tube(self, start, end, radius):
        """Points within a radius of a segment."""
        start, along = np.array(start, float), np.array(end, float) - start
        offset = [p - s for p, s in zip((self.x, self.y, self.z), start, strict=True)]
        share = sum(o * a for o, a in zip(offset, along, strict=True)) / (along @ along)
        share = np.clip(share, 0, 1)
        return sum((o - share * a) ** 2 for o, a in zip(offset, along, strict=True)) <= radius**2

    def ball(self, centre, radius):
        pairs = zip((self.x, self.y, self.z), centre, strict=True)
        return sum((p - c) ** 2 for p, c in pairs) <= radius**2

    def cavity(self, side):
        inside = (self.x / 112) ** 2 + (self.y / 78) ** 2 < 1
        return inside & (side * self.x > 24) & (abs(self.z) < 85)

    def _draw(self, fluid_behind, lung_hu):
        self.draw((self.x / 138) ** 2 + (self.y / 96) ** 2 < 1, 50, BODY)
        spine = self.x**2 + (self.y - 60) ** 2
        self.draw(spine < 17**2, 700, BONE)
        self.draw(spine < 12**2, 150, BONE)
        self.draw(self.cavity(1), lung_hu, LEFT_LUNG)
        self.draw(self.cavity(-1), lung_hu, RIGHT_LUNG)
        if fluid_behind is not None:
            self.draw(self.cavity(-1) & (self.y > fluid_behind), 8, EFFUSION)
        courses = [((0, -10, 200), (0, -10, 20), 8.0)]
        courses += [((0, -10, 20), (side * 42, -10, 5), 6.5) for side in (-1, 1)]
        for wall, hu, label in ((3.5, 40, BODY), (0.0, -1000, AIRWAY)):
            for start, end, radius in courses:
                self.draw(self.tube(start, end, radius + wall), hu, label)

    @property
    def ct(self) -> Volume:
        noise = np.random.default_rng(0).normal(size=self.hu.shape) * self.noise
        voxels = np.clip(np.rint(self.hu + noise), -1024, 3071).astype(np.int16)
        return Volume(voxels, self.patient_from_index, "HU", Origin("cylinders"))

    @property
    def truth(self) -> LabelMap:
        return LabelMap(self.labels, self.patient_from_index, NAMES, Origin("cylinders"))


def turned(volume, axes, flips):
    """The same image stored along other axes and in other directions."""
    voxels = volume.voxels.transpose(axes)
    own_from_turned = np.zeros((4, 4))
    own_from_turned[3, 3] = 1
    for place, axis in enumerate(axes):
        last = volume.voxels.shape[axis] - 1
        own_from_turned[axis, place] = -1 if flips[place] else 1
        own_from_turned[axis, 3] = last if flips[place] else 0
    for place, flip in enumerate(flips):
        voxels = np.flip(voxels, place) if flip else voxels
    transform = volume.patient_from_index @ own_from_turned
    return replace(volume, voxels=np.ascontiguousarray(voxels), patient_from_index=transform)
