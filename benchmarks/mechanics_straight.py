"""Straight, unloaded CRISP robots in lanes: along edges, from the parent, cold, sampled."""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.mechanics_edges import FOLLOW, edge_error, edges_between, ends_of, random_targets
from benchmarks.mechanics_timing import Row, cpu_us
from nodes.mechanics.crisp_edges import SOLVED, CrispEdges
from nodes.mechanics.crisp_jacobians import crisp_jacobians
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.mechanics.sample_crisp_needles import sample_crisp_needles

COUNT, STEPS = 960, 10  # edges in a batch, steps of 1 mm and 1 degree along each
CPP_MARK_US = 1e6 / 246_000  # chord iteration in C++, one core, two tubes

# Multiplications and additions of one residual of straight robots: a rod's two steps of order 8 in
# place and frame, and a joint. A warm solve needs one residual and one chord update at least, a
# cold one four with derivatives.
ROD, JOINT, CHORD = 2 * 12 * 60, 120, 72


def operations(needles: int, residuals: float) -> float:
    """Return how many operations so many residuals of straight robots take."""
    rods = (2 * needles - 1) * ROD
    joints = (needles - 1) * JOINT
    return residuals * (rods + joints + CHORD * (needles - 1) ** 2)


@dataclass(frozen=True)
class Bundle:
    """Edges of one robot from solved starts, all of one length.

    starts, near, ends : (edge, needle, 4) offsets from `first`, degrees and mm: where edges start,
        one step of 1 mm or 1 degree on, and at their ends.
    seeds : (edge, needle, 6) base wrenches at the starts.
    """

    setup: CrispSetup
    first: CrispConfiguration
    starts: np.ndarray
    near: np.ndarray
    ends: np.ndarray
    seeds: np.ndarray

    def edges(self, ends: np.ndarray, steps: int, *, seeded: bool = True) -> CrispEdges:
        edges = edges_between(self.first, self.starts, ends, steps)
        return replace(edges, start_wrenches=self.seeds) if seeded else edges

    def us(self, edges: CrispEdges, repeats: int) -> float:
        """Return us an edge."""
        return cpu_us(
            lambda: follow_crisp_edges(self.setup, edges, FOLLOW), len(self.starts), repeats
        )


def make_bundle(setup: CrispSetup, first: CrispConfiguration) -> Bundle:
    """Return edges between random targets about an assembled robot."""
    chance, needles = np.random.default_rng(7), len(first.lengths_mm)
    starts, ends = (random_targets(chance, needles, COUNT) for _ in range(2))
    arrive = edges_between(first, 0 * starts, starts)
    seeds = ends_of(arrive, follow_crisp_edges(setup, arrive, FOLLOW))
    kept = ~np.isnan(seeds).any((1, 2))
    starts, ends, seeds = starts[kept], ends[kept], np.ascontiguousarray(seeds[kept])
    way = ends - starts
    largest = np.maximum(np.linalg.norm(way[..., :3], axis=2), np.abs(way[..., 3])).max(1)
    step = way / largest[:, None, None]
    return Bundle(setup, first, starts, starts + step, starts + STEPS * step, seeds)


def measure_straight(setup, first, repeats, flops, asked) -> list[Row]:
    """Return rows of the lanes' path: along edges, from the parent's solution, cold, sampled."""
    bundle, needles = make_bundle(setup, first), len(first.lengths_mm)
    name, wide = f"{needles} tubes, straight, ", flops[0]
    long, here = bundle.edges(bundle.ends, STEPS), bundle.edges(bundle.starts, 0)
    tracks = follow_crisp_edges(setup, long, FOLLOW)
    error = edge_error(setup, first, bundle.ends, long, tracks)
    note = f"{len(bundle.starts)} edges of {STEPS} steps"
    if lost := int((tracks.status != SOLVED).sum()):
        note += f", {lost} steps not solved"
    base = bundle.us(here, repeats)
    along = (bundle.us(long, repeats) - base) / STEPS
    parent = bundle.us(bundle.edges(bundle.near, 1), repeats) - base
    mark = CPP_MARK_US if needles == 2 else None
    return [
        Row(name + "along edges", along, asked, operations(needles, 2) / wide, error, note),
        Row(name + "the same with starts, against C++", base / STEPS + along, mark),
        Row(name + "parent's solution", parent, asked, operations(needles, 3) / wide),
        Row(name + "start given, checked", base, None, operations(needles, 1) / wide),
        *measure_cold(bundle, name, repeats, wide),
        *measure_samples(bundle, name, repeats, along),
        *measure_calls(bundle, name),
    ]


def measure_cold(bundle: Bundle, name: str, repeats: int, wide: float) -> list[Row]:
    """Return the row of solves from no wrench."""
    cold = bundle.edges(bundle.starts, 0, seeded=False)
    tracks = follow_crisp_edges(bundle.setup, cold, FOLLOW)
    error = edge_error(bundle.setup, bundle.first, bundle.starts, cold, tracks)
    limit = operations(len(bundle.first.lengths_mm), 12) / wide
    return [Row(name + "cold, 8 deg / 4 mm", bundle.us(cold, repeats), None, limit, error)]


def measure_samples(bundle: Bundle, name: str, repeats: int, along: float) -> list[Row]:
    """Return the row of solves along edges with 50 points on the needles together."""
    here = bundle.edges(bundle.starts, 0)
    pieces = 24 if len(bundle.first.lengths_mm) == 2 else 12

    def sample():
        return sample_crisp_needles(
            bundle.setup, here.starts, here.start_lengths_mm, bundle.seeds, pieces
        )

    points = sample()
    count = points.tool_patient_mm.shape[1] + int(np.prod(points.snares_patient_mm.shape[1:3]))
    us = along + cpu_us(sample, len(bundle.starts), repeats)
    return [Row(name + f"along edges, {count} samples", us)]


def measure_calls(bundle: Bundle, name: str) -> list[Row]:
    """Return rows of single calls, as a person in a notebook meets them."""
    one = edges_between(bundle.first, bundle.starts[:1], bundle.near[:1], 1)
    one = replace(one, start_wrenches=bundle.seeds[:1])
    still = edges_between(bundle.first, 0 * bundle.starts[:1], 0 * bundle.starts[:1], 0)
    wrenches = follow_crisp_edges(bundle.setup, still, FOLLOW).wrenches[0, 0]
    derivatives = cpu_us(
        lambda: crisp_jacobians(bundle.setup, bundle.first, wrenches, FOLLOW.tolerance_mm), 1, 50
    )
    step = cpu_us(lambda: follow_crisp_edges(bundle.setup, one, FOLLOW), 1, 50)
    return [
        Row(name + "one edge of one step from Python", step),
        Row(name + "all Jacobians of one, from Python", derivatives),
    ]
