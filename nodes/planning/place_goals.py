"""Goals on the surface of the free space: marked points, painted regions, random places."""

import numpy as np
from jaxtyping import Float, Int

from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, spacing_mm
from nodes.geometry.origin import Origin
from nodes.geometry.sites import Sites
from nodes.planning.artefacts import Goals
from nodes.planning.parameters import PlaceGoalsParameters
from nodes.planning.surface_cells import find_surface_cells

Points = Float[np.ndarray, "n 3"]
Cells = Int[np.ndarray, "n 3"]

NONE_GIVEN = "no goal is given: set-ups are judged by all that they see"


def place_goals(
    sites: Sites, label_map: LabelMap, occupancy_grid: LabelMap, parameters: PlaceGoalsParameters
) -> Goals:
    """Find the cells of the free space's surface that are to be seen.

    A cell counts if a free cell shares a face with it, since no other can be seen. A marked point
    is the cell whose box is nearest to it; poses count by their place. A painted region is all
    cells whose centres lie in a voxel of the label, or within half a cell of one.

    Parameters
    ----------
    sites : what a person marked; may be none.
    label_map : in which regions are painted as labels of their own.
    occupancy_grid : whose boundary cells count.
    parameters : how far a point may be off, which labels are goals, how many places at random.

    Raises
    ------
    BadInput where a point is off the surface, or a region unknown or nowhere on it.
    """
    cells = find_surface_cells(occupancy_grid)
    centres = transform_points(occupancy_grid.patient_from_index, cells.astype(float))
    found = []
    for name, point in zip(sites.names, sites.places_patient_mm, strict=True):
        nearest = _snap(name, point, cells, occupancy_grid, parameters.snap_mm)
        found.append((name, np.array([nearest]), point))
    for name in parameters.goal_labels:
        inside = _cover(name, label_map, centres, occupancy_grid)
        found.append((name, inside, _middle(centres[inside])))
    chance = np.random.default_rng(parameters.seed)
    count = min(parameters.random_goals, len(cells))
    for number, cell in enumerate(chance.choice(len(cells), count, replace=False), start=1):
        found.append((f"random {number}", np.array([cell]), centres[cell]))
    return Goals(
        tuple(name for name, _, _ in found),
        cells[np.concatenate([np.empty(0, int), *(own for _, own, _ in found)])],
        np.repeat(np.arange(len(found)), [len(own) for _, own, _ in found]),
        np.array([point for _, _, point in found]).reshape(-1, 3),
        _tell(sites, occupancy_grid, parameters, count),
    )


def _tell(
    sites: Sites, grid: LabelMap, parameters: PlaceGoalsParameters, random_goals: int
) -> Origin:
    marked = len(sites.names)
    parts = [f"{marked} marked places"] * bool(marked)
    parts += [f"the painted region {name}" for name in parameters.goal_labels]
    parts += [f"{random_goals} random places"] * bool(random_goals)
    source = f"{' and '.join(parts) or 'no goals'} on the surface of {grid.origin.source}"
    simulated = grid.origin.simulated or (bool(marked) and sites.origin.simulated)
    origin = Origin(source, simulated, grid.origin.notices).with_notice(
        *(sites.origin.notices if marked else ())
    )
    if random_goals:
        origin = origin.with_notice(
            f"{random_goals} goals are places on the surface drawn at random, of no medical meaning"
        )
    return origin if parts else origin.with_notice(NONE_GIVEN)


def _snap(
    name: str, point: Float[np.ndarray, "3"], cells: Cells, grid: LabelMap, most_mm: float
) -> int:
    """Return which cell's box is nearest to a point."""
    spacing = spacing_mm(grid.patient_from_index)
    index = transform_points(np.linalg.inv(grid.patient_from_index), point[None])[0]
    distances = _gaps(index, cells.astype(float), spacing)
    # Of boxes that are equally near the one with the nearest centre.
    centred = np.linalg.norm((cells - index) * spacing, axis=1)
    nearest = int(np.lexsort((centred, distances.round(6)))[0])
    if distances[nearest] > most_mm:
        place = np.clip(index, cells[nearest] - 0.5, cells[nearest] + 0.5)
        raise _off_surface(name, point, transform_points(grid.patient_from_index, place[None])[0],
                           float(distances[nearest]), most_mm)  # fmt: skip
    return nearest


def _off_surface(
    name: str, point: Float[np.ndarray, "3"], nearest: Float[np.ndarray, "3"],
    distance_mm: float, most_mm: float,
) -> BadInput:  # fmt: skip
    x, y, z = (float(c) for c in nearest)
    return BadInput(
        f"goal {name} at patient LPS {_written(point)} mm is {distance_mm:.1f} mm off the surface"
        " of the free space",
        f"a goal lies within snap_mm = {most_mm:g} mm of that surface",
        f"move it to the nearest place there, LPS {_written(nearest)} mm (in 3D Slicer, which shows"
        f" RAS, {_written(np.array([-x, -y, z]))} mm), or raise snap_mm",
    )


def _written(point: Float[np.ndarray, "3"]) -> str:
    return ", ".join(f"{float(c):.1f}" for c in point)


def _cover(
    name: str, label_map: LabelMap, centres: Points, grid: LabelMap
) -> Int[np.ndarray, " covered"]:
    """Return which cells' centres lie within half a cell of a voxel of a label."""
    from scipy.spatial import cKDTree

    if name not in label_map.names:
        raise BadInput(
            f"goal_labels: {name}",
            f"the label map has the labels {', '.join(label_map.names)}",
            "paint the region as a label of its own, or leave it out of goal_labels",
        )
    spacing = spacing_mm(label_map.patient_from_index)
    voxels = np.argwhere(label_map.mask(name)).reshape(-1, 3).astype(float)
    half = float(spacing_mm(grid.patient_from_index).max()) / 2
    painted = cKDTree(transform_points(label_map.patient_from_index, voxels))
    near = painted.query_ball_point(centres, half + float(np.linalg.norm(spacing)) / 2)
    index = transform_points(np.linalg.inv(label_map.patient_from_index), centres)
    covered = [
        cell
        for cell, found in enumerate(near)
        if found and _gaps(index[cell], voxels[found], spacing).min() <= half
    ]
    if not covered:
        raise BadInput(
            f"goal_labels: {name} has no place on the surface of the free space",
            f"a painted region comes within half a cell, {half:g} mm, of a boundary cell's centre",
            "paint it over the surface, some voxels thick",
        )
    return np.array(covered)


def _gaps(
    index: Float[np.ndarray, "3"], voxels: Points, spacing: Float[np.ndarray, "3"]
) -> Float[np.ndarray, " n"]:
    """Return the distances from a point to voxels' boxes, mm."""
    return np.linalg.norm(np.maximum(abs(voxels - index) - 0.5, 0) * spacing, axis=1)


def _middle(points: Points) -> Float[np.ndarray, "3"]:
    """Return the point that is nearest to the middle of all."""
    return points[np.linalg.norm(points - points.mean(axis=0), axis=1).argmin()]
