"""How fast the surface of a cavity is looked at, against one ray a cell in the same run.

    python -m benchmarks.crisp_planning_views [--nodes 20000] [--repeats 5]

The cavity is an ellipsoid of 200 x 120 x 80 mm in cells of 1 mm; the cameras are those of a tree of
a tool that turns about an entry point. All times are CPU time of one core, in ms a node.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pipelines.kernel_cache import use_kernel_cache

use_kernel_cache(Path(__file__).resolve().parent.parent)  # before anything imports Numba

from nodes.geometry import lines_of_sight  # noqa: E402
from nodes.geometry.grids import LabelMap  # noqa: E402
from nodes.geometry.lines_of_sight import (  # noqa: E402
    Reading,
    SurfaceCells,
    find_surface,
    half_view,
    look,
    look_anew,
    look_plainly,
)
from nodes.geometry.origin import Origin  # noqa: E402

HALVES_MM = np.array([100.0, 60.0, 40.0])
ANGLES, READINGS = (70.0, 90.0, 120.0), ("own ray", "first hit")
WANTED_MS = 0.06  # a node, with a field of view of 90 degrees
SHORT = 1000  # nodes
FRESH = 200  # cameras that look at a surface of which nothing has been seen
MARGIN_CELLS = 2.0  # between the camera and the wall, as a needle's radius and margin leave


def made_cavity() -> LabelMap:
    """Return the occupancy grid of the ellipsoid, its centre at the patient frame's origin."""
    shape = tuple(2 * HALVES_MM.astype(int) + 5)
    patient_from_index = np.eye(4)
    patient_from_index[:3, 3] = -(np.array(shape) - 1) / 2
    places = np.stack(np.indices(shape), axis=-1) + patient_from_index[:3, 3]
    free = ((places / HALVES_MM) ** 2).sum(axis=-1) <= 1
    labels, padded = free.astype(np.uint8), np.pad(free, 1)
    for axis in range(3):
        for step in (-1, 1):
            beside = np.roll(padded, step, axis)[1:-1, 1:-1, 1:-1]
            labels[beside & ~free] = 2
    return LabelMap(labels, patient_from_index, ("free", "boundary"), Origin("an ellipsoid", True))


def tree_cameras(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return places and views of a tree that grows over tilts, depth and bend of a tool."""
    from scipy.spatial import cKDTree

    rng, low = np.random.default_rng(0), np.array([-1.1, -1.1, 15.0, -0.9, -0.9])
    high, scale = np.array([1.1, 1.1, 120.0, 0.9, 0.9]), np.array([40.0, 40.0, 1.0, 40.0, 40.0])
    nodes = np.array([[0.0, 0.0, 30.0, 0.0, 0.0]])
    while len(nodes) < count:
        goals = rng.uniform(low, high, (max(len(nodes) // 4, 1), 5))
        near = cKDTree(nodes * scale).query(goals * scale)[1]
        ways = rng.uniform(0, 1, (len(goals), 1)) * (goals - nodes[near])
        # as far along each way as the camera stays inside
        share = np.linspace(0, 1, 60)[:, None, None]
        inside = _is_inside(_pose(nodes[near] + share * ways)[0])
        steps = np.logical_and.accumulate(inside, axis=0).sum(axis=0) - 1
        kept = steps > 0
        nodes = np.concatenate([nodes, (nodes[near] + (steps / 59)[:, None] * ways)[kept]])
    return _pose(nodes[:count])


def _pose(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    axis = np.array([0.35, 0.0, -1.0]) / np.hypot(0.35, 1.0)
    side = np.array([1.0, 0.0, 0.35]) / np.hypot(0.35, 1.0)
    other = np.array([0.0, 1.0, 0.0])
    tool = _unit(axis + np.tan(nodes[..., 0:1]) * side + np.tan(nodes[..., 1:2]) * other)
    view = _unit(tool + np.tan(nodes[..., 3:4]) * side + np.tan(nodes[..., 4:5]) * other)
    return np.array([-40.0, 0.0, 36.0]) + nodes[..., 2:3] * tool, view


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _is_inside(places: np.ndarray) -> np.ndarray:
    return ((places / (HALVES_MM - MARGIN_CELLS)) ** 2).sum(axis=-1) <= 1


def run_views(nodes: int = 20_000, repeats: int = 5) -> tuple[list[str], dict[str, Any]]:
    """Return the table's lines and the figures, by reading and field of view."""
    parts = lines_of_sight.PARTS
    lines_of_sight.PARTS = 1  # CPU time of one thread, and nothing that two share
    try:
        return _run_views(nodes, repeats)
    finally:
        lines_of_sight.PARTS = parts


def _run_views(nodes: int, repeats: int) -> tuple[list[str], dict[str, Any]]:
    surface = find_surface(made_cavity())
    cameras, views = tree_cameras(nodes)
    lines = [
        f"{len(surface.cells):,} cells, {nodes:,} nodes; CPU ms a node",
        f"{'reading':10} {'field':>6} {'fresh':>8} {'ray each':>9} {'1000 nodes':>10} {'run':>9}"
        f" {'ray each':>9}"
        f" {'ratio':>7} {'asked':>6} {'seen':>6} same",
    ]
    figures: dict[str, Any] = {"cells": len(surface.cells), "nodes": nodes}
    for reading in READINGS:
        for angle in ANGLES:
            found = _measure(surface, cameras, views, angle, reading, repeats)
            figures[f"{reading}, {angle:g} deg"] = found
            fresh = "" if found["fresh_ms"] is None else f"{found['fresh_ms']:.3f}"
            asked = WANTED_MS if (reading, angle) == ("own ray", 90.0) else None
            lines.append(
                f"{reading:10} {angle:6g} {fresh:>8} {found['fresh_plain_ms']:9.3f}"
                f" {found['short_ms']:10.5f}"
                f" {found['run_ms']:9.5f} {found['run_plain_ms']:9.3f}"
                f" {found['run_plain_ms'] / found['run_ms']:6.0f}x"
                f" {'' if asked is None else 'yes' if found['run_ms'] <= asked else 'NO':>6}"
                f" {found['share_seen']:6.1%} {'yes' if found['same'] else 'NO'}"
            )
    return lines, figures


def _measure(
    surface: SurfaceCells,
    cameras: np.ndarray,
    views: np.ndarray,
    angle: float,
    reading: Reading,
    repeats: int,
) -> dict[str, Any]:
    """Return times a node over a run, of cameras that look first, and of one ray a cell."""
    some = np.linspace(0, len(cameras) - 1, 40).astype(int)
    first_nodes = np.full(len(surface.cells), -1)

    def run(nodes: int = len(cameras)) -> None:
        first_nodes[:] = -1
        look(surface, cameras[:nodes], views[:nodes], angle, reading, first_nodes)

    def rays(chosen: np.ndarray) -> np.ndarray:
        found = np.full(len(surface.cells), -1)
        look_plainly(surface, (cameras[chosen], views[chosen], half_view(angle)), reading, 0, found)
        return found

    run(), rays(some[:1])  # compiled
    step = max(1, len(cameras) // FRESH)
    alone, rays_alone = _measure_fresh(surface, cameras[::step], views[::step], angle, reading)
    short, fast = np.arange(200), np.full(len(surface.cells), -1)
    look(surface, cameras[short], views[short], angle, reading, fast)
    return {
        "fresh_ms": alone,
        "fresh_plain_ms": rays_alone,
        "short_ms": min(_cpu_ms(lambda: run(SHORT)) for _ in range(repeats)) / SHORT,
        "run_ms": min(_cpu_ms(run) for _ in range(repeats)) / len(cameras),
        "run_plain_ms": min(_cpu_ms(lambda: rays(some)) for _ in range(2)) / len(some),
        "share_seen": float((first_nodes >= 0).mean()),
        "same": bool((fast == rays(short)).all()),
    }


def _measure_fresh(
    surface: SurfaceCells, cameras: np.ndarray, views: np.ndarray, angle: float, reading: Reading
) -> tuple[float | None, float]:
    """Return ms a node when nothing has been seen before, and of one ray a cell."""

    def rays() -> None:
        for node in range(len(cameras)):
            one = cameras[[node]], views[[node]], half_view(angle)
            look_plainly(surface, one, reading, 0, np.full(len(surface.cells), -1))

    def alone() -> None:
        look_anew(surface, cameras, views, angle)

    plain = min(_cpu_ms(rays) for _ in range(2)) / len(cameras)
    if reading != "own ray":
        return None, plain
    alone()
    return min(_cpu_ms(alone) for _ in range(3)) / len(cameras), plain


def _cpu_ms(work: Callable[[], Any]) -> float:
    started = time.process_time()
    work()
    return (time.process_time() - started) * 1e3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, default=20_000)
    parser.add_argument("--repeats", type=int, default=5)
    chosen = parser.parse_args()
    lines, figures = run_views(chosen.nodes, chosen.repeats)
    print("\n".join(lines))
    print(json.dumps({"views": figures}))


if __name__ == "__main__":
    main()
