"""The start nearest to one that does not work."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from nodes.mechanics.check_robots import grasp_arc_mm
from nodes.mechanics.robots import CrispConfiguration
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.setup_judging import Frames, Lengths, Scene, find_tilts, judge_starts
from nodes.planning.setup_starts import Entries, Limits, lay_starts, roll_needles, spread_tangents

WAYS = 16  # places that are tried on the straight way to a start that works
FACTOR = 2.0  # by which the search goes further out each time
JUDGED_ALONE = 8  # nearest ones that are judged again, as the start will be: one by one
QUATERNION_DIGITS, LENGTH_DIGITS = 6, 2  # that a person has to paste


class Search(NamedTuple):
    """How far and how finely a start is sought.

    farthest : size of a change: the root of the sum of squares of all needles' turns, degrees, and
        changes of length, mm.
    tries : starts that are tried at each distance.
    seed : of the changes.
    """

    farthest: float
    tries: int
    seed: int


class Offer(NamedTuple):
    """A start that works, and how far it is, in the measure of Search."""

    start: CrispConfiguration
    distance: float


class Tried(NamedTuple):
    """Configurations, rounded as a person would paste them."""

    frames: Frames
    lengths: Lengths

    def take(self, rows: np.ndarray) -> "Tried":
        return Tried(self.frames[rows], self.lengths[rows])


def find_nearest(placed: PlacedSetup, scene: Scene, search: Search) -> Offer | None:
    """Return the nearest start that works among those tried, or None.

    Starts at which no needle is bent are tried, and changes of all joints at once, drawn from balls
    that grow until one of them works; then places on the straight way to it.
    """
    best = _nearest_of(placed, _unbent(placed, search.tries), scene)
    chance = np.random.default_rng(search.seed)
    size = 1.0
    while size < FACTOR * search.farthest:
        if best is not None and best.distance < size / FACTOR:
            break
        changes = _draw(chance, min(size, search.farthest), search.tries, len(placed.axes))
        found = _nearest_of(placed, _change(placed, changes), scene)
        if found is not None:
            nearer = _nearest_of(placed, _on_the_way(placed, found.start), scene)
            offers = [offer for offer in (best, found, nearer) if offer is not None]
            return min(offers, key=lambda offer: offer.distance)
        size *= FACTOR
    return best


def write_start(start: CrispConfiguration) -> str:
    """Return a configuration as lines of its file."""
    from scipy.spatial.transform import Rotation

    quaternions = Rotation.from_matrix(start.patient_from_entry).as_quat(scalar_first=True)
    turns = [
        "      - quaternion: [" + ", ".join(f"{q:.{QUATERNION_DIGITS}f}" for q in row) + "]"
        for row in quaternions
    ]
    lengths = ", ".join(f"{length:.{LENGTH_DIGITS}f}" for length in start.lengths_mm)
    return "\n".join([f"    lengths_mm: [{lengths}]", "    orientations:", *turns])


def _nearest_of(placed: PlacedSetup, tried: Tried, scene: Scene) -> Offer | None:
    """Return the nearest of configurations that is within the limits and works."""
    tried = tried.take(_within_limits(placed, tried))
    if not len(tried.lengths):
        return None
    works = judge_starts(placed.setup, tried.frames, tried.lengths, scene) == 0
    if not works.any():
        return None
    tried = tried.take(works)
    distances = _distances(placed.start, tried)
    for nearest in np.argsort(distances, kind="stable")[:JUDGED_ALONE]:
        alone = tried.take(np.array([nearest]))
        if judge_starts(placed.setup, alone.frames, alone.lengths, scene)[0] == 0:
            start = CrispConfiguration(alone.frames[0], alone.lengths[0])
            return Offer(start, float(distances[nearest]))
    return None


def _within_limits(placed: PlacedSetup, tried: Tried) -> Bool[np.ndarray, " robot"]:
    fits = (find_tilts(placed, tried.frames) <= placed.largest_tilts_rad).all(axis=1)
    fits &= (tried.lengths >= placed.shortest_mm).all(axis=1)
    fits &= (tried.lengths <= placed.longest_mm).all(axis=1)
    for snare in placed.setup.snares:
        arcs = np.array([grasp_arc_mm(snare, float(length)) for length in tried.lengths[:, 0]])
        fits &= (arcs > 0) & (arcs <= tried.lengths[:, 0])
    return fits


def _distances(start: CrispConfiguration, tried: Tried) -> Float[np.ndarray, " robot"]:
    turns = _turns_between(start.patient_from_entry, tried.frames)
    grown = tried.lengths - start.lengths_mm
    return np.sqrt((np.degrees(turns) ** 2).sum(axis=(1, 2)) + (grown**2).sum(axis=1))


def _turns_between(
    frames: Float[np.ndarray, "needle 3 3"], others: Frames
) -> Float[np.ndarray, "robot needle 3"]:
    """Return the rotation vectors, in patient axes, from one robot's frames to others'."""
    from scipy.spatial.transform import Rotation

    turns = others @ frames.swapaxes(-1, -2)
    return Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec().reshape(*others.shape[:2], 3)


def _draw(
    chance: np.random.Generator, size: float, tries: int, needles: int
) -> Float[np.ndarray, "robot needle 4"]:
    """Return changes evenly in a ball: turns of needles, rad, and growths, mm."""
    changes = chance.normal(size=(tries, needles * 4))
    changes /= np.linalg.norm(changes, axis=1, keepdims=True)
    changes *= size * chance.uniform(size=(tries, 1)) ** (1 / changes.shape[1])
    changes = changes.reshape(tries, needles, 4)
    changes[..., :3] = np.radians(changes[..., :3])
    return changes


def _change(placed: PlacedSetup, changes: Float[np.ndarray, "robot needle 4"]) -> Tried:
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_rotvec(changes[..., :3].reshape(-1, 3)).as_matrix()
    turned = turns.reshape(*changes.shape[:2], 3, 3) @ placed.start.patient_from_entry
    return _round(turned, placed.start.lengths_mm + changes[..., 3])


def _on_the_way(placed: PlacedSetup, end: CrispConfiguration) -> Tried:
    """Return places on the way from the start to another configuration."""
    turns = _turns_between(placed.start.patient_from_entry, end.patient_from_entry[None])[0]
    change = np.concatenate([turns, (end.lengths_mm - placed.start.lengths_mm)[:, None]], axis=1)
    shares = np.arange(1, WAYS) / WAYS
    return _change(placed, shares[:, None, None] * change)


def _unbent(placed: PlacedSetup, count: int) -> Tried:
    """Return starts at which no needle is bent, if the set-up has such: one snare, at right angles,
    that holds the tool's material."""
    snares = placed.setup.snares
    if len(snares) != 1 or snares[0].cosine != 0 or snares[0].measured_from != "tip":
        return Tried(np.zeros((0, len(placed.axes), 3, 3)), np.zeros((0, len(placed.axes))))
    entries = Entries(np.arange(2), placed.setup.entry_points_patient_mm, placed.axes)
    limits = Limits(float(placed.largest_tilts_rad.max()), 0.0, float(placed.longest_mm.max()), 0.0)
    tangents = spread_tangents(entries.axes, float(placed.largest_tilts_rad[0]), count)
    starts = lay_starts(entries, tangents, snares[0].grasp_mm, limits)
    starts = starts.take(starts.tools == 0)
    tools, others = roll_needles(starts.tangents, starts.snare_tangents)
    lengths = np.stack([starts.feet_mm + snares[0].grasp_mm, starts.reaches_mm], axis=1)
    return _round(np.stack([tools, others], axis=1), lengths)


def _round(frames: Frames, lengths: Lengths) -> Tried:
    """Return configurations as they are once their written numbers are read again."""
    from scipy.spatial.transform import Rotation

    quaternions = Rotation.from_matrix(frames.reshape(-1, 3, 3)).as_quat(scalar_first=True)
    rounded = Rotation.from_quat(quaternions.round(QUATERNION_DIGITS), scalar_first=True)
    turned = rounded.as_matrix().reshape(frames.shape)
    return Tried(turned, lengths.round(LENGTH_DIGITS))
