"""The door to pyvista: pictures of meshes, drawn off-screen in a separate process (see `kanefe.views.pictures`)."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyvista

from kanefe.views.artist import serve

COLOURS = "turbo"
STEEPEST = 0.7
"""Largest change of a drawn mode along a side, relative to the side, so that twisted bars remain recognisable."""

INK = "#222222"
PAPER = "#ffffff"

LINES_AND_POINTS = (1, 3, 21)
"""VTK's numbers of the types of cells that are lines and points."""

NODE, IS_SOLID = "node", "is solid"
"""Names of the point data and the field data of a surface."""

_KEPT: dict[str, Any] = {}

Mesh = list[tuple[int, np.ndarray]]
"""VTK's number of the shape and the nodes (m, nodes per cell), for each block of cells."""


def draw_all(folder: Path) -> None:
    """Draw the pictures of a job into its folder: 0.png, 1.png, ..."""
    _KEPT.clear()  # its keys are addresses, which arrays of another job may reuse
    arrays = dict(np.load(folder / "job.npz"))
    jobs = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    for number, job in enumerate(jobs):
        cells: Mesh = [(kind, arrays[name]) for kind, name in job["cells"]]
        draw = draw_field if job["draw"] == "field" else draw_shape
        image = draw(arrays[job["points"]], cells, arrays[job["values"]], **job["options"])
        save(image, folder / f"{number}.png")


def draw_field(
    points: np.ndarray,
    cells: Mesh,
    values: np.ndarray,
    *,
    label: str,
    view: list[float],
    title: str | None,
    limit: float | None,
    size: list[int],
) -> np.ndarray:
    """Return a picture of a mesh, coloured by a field (n,)."""
    bar = {
        "title": label,
        "color": INK,
        "vertical": True,
        "position_x": 0.87,
        "position_y": 0.15,
        "height": 0.7,
        "width": 0.05,
        "title_font_size": 22,
        "label_font_size": 20,
        "fmt": "%.3g",
        "n_labels": 6,
        "font_family": "arial",
    }
    finite = values[np.isfinite(values)]
    low, high = min(0.0, float(finite.min(initial=0.0))), float(finite.max(initial=0.0)) if limit is None else limit
    with plotter_of(size) as plotter:
        surface = surface_of(points, cells)
        surface.point_data["values"] = values[surface.point_data[NODE]]
        add(plotter, surface, scalars="values", cmap=COLOURS, clim=(low, high or 1.0), scalar_bar_args=bar)
        if title:
            plotter.add_text(title, position=(24, size[1] - 48), font_size=13, color=INK, font="arial")
        look(plotter, np.array(view), 1.05)
        plotter.camera.SetWindowCenter(0.1, 0.0)  # room for the colours on the right
        return np.asarray(plotter.screenshot(return_img=True))


def draw_shape(
    nodes: np.ndarray, cells: Mesh, displacement: np.ndarray, *, amplitude: float, size: list[int]
) -> np.ndarray:
    """Return a picture of a mode shape (n, 3), coloured by its motion, over the undeformed mesh."""
    extent = np.ptp(nodes, axis=0)
    moved = np.linalg.norm(displacement, axis=1)
    factor = amplitude * float(extent.max()) / float(moved.max() or 1.0)
    factor = min(factor, STEEPEST / steepness(nodes, cells, displacement))
    surface = surface_of(nodes, cells)
    with plotter_of(size) as plotter:
        add(plotter, surface, color="#b8bec6", opacity=0.25)
        shown = moved_surface(surface, factor * displacement)
        shown.point_data["motion"] = moved[shown.point_data[NODE]]
        add(plotter, shown, scalars="motion", cmap="viridis", show_scalar_bar=False)
        look(plotter, best_view(extent), 1.25)
        return np.asarray(plotter.screenshot(return_img=True))


def steepness(nodes: np.ndarray, cells: Mesh, displacement: np.ndarray) -> float:
    """Return the greatest change of a displacement between nodes of a cell, relative to their distance."""
    steepest = 1e-300
    for _, table in cells:
        for other in range(1, min(table.shape[1], 4)):
            a, b = table[:, 0], table[:, other]
            change = np.linalg.norm(displacement[b] - displacement[a], axis=1)
            steepest = max(steepest, float((change / np.linalg.norm(nodes[b] - nodes[a], axis=1)).max(initial=0.0)))
    return steepest


def save(image: np.ndarray, path: Path) -> None:
    """Write an image (height, width, 3) as a small .png file."""
    from PIL import Image

    Image.fromarray(np.asarray(image, dtype=np.uint8)).save(path, format="png", optimize=True)


def best_view(extent: np.ndarray) -> np.ndarray:
    """Return a direction that shows the largest sides of a body."""
    view = np.array([0.9, -1.2, 0.8])
    view[int(np.argmin(extent))] *= 1.6
    view[int(np.argmax(extent))] *= 0.6
    return view


def grid_of(points: np.ndarray, cells: Mesh) -> pyvista.DataSet:
    """Return the mesh in VTK's form; only its nodes if it has no cells."""
    if not cells:
        return pyvista.PolyData(np.asarray(points, dtype=float))
    kinds = [np.full(len(nodes), kind, dtype=np.uint8) for kind, nodes in cells]
    table = [np.hstack((np.full((len(nodes), 1), nodes.shape[1]), nodes)).ravel() for _, nodes in cells]
    return pyvista.UnstructuredGrid(np.concatenate(table), np.concatenate(kinds), np.asarray(points, dtype=float))


def surface_of(points: np.ndarray, cells: Mesh) -> pyvista.DataSet:
    """Return the outer surface of a mesh, split along its edges, with the number of the node at each of its points.

    Lines and points are returned unchanged. The surface of the last mesh is cached for the mode shapes of a report.
    """
    key = (id(points), *(id(nodes) for _, nodes in cells))
    if _KEPT.get("key") != key:
        _KEPT.update(key=key, surface=_surface(grid_of(points, cells)))
    kept: pyvista.DataSet = _KEPT["surface"]
    return kept.copy()


def _surface(grid: pyvista.DataSet) -> pyvista.DataSet:
    grid.point_data[NODE] = np.arange(grid.n_points)
    if not isinstance(grid, pyvista.UnstructuredGrid) or np.isin(grid.celltypes, LINES_AND_POINTS).all():
        return grid
    grid.field_data[IS_SOLID] = [1]
    # one level of subdivision represents mid-side nodes exactly
    surface = grid.extract_surface(nonlinear_subdivision=1, algorithm="dataset_surface")
    gaps = surface.points - grid.points[surface.point_data[NODE].astype(int)]  # VTK's surfaces are of single precision
    if np.abs(gaps).max(initial=0.0) > 1e-5 * np.abs(grid.points).max():  # the subdivision has added points
        surface = grid.extract_surface(nonlinear_subdivision=0, algorithm="dataset_surface")
    return surface.compute_normals(cell_normals=False, split_vertices=True, feature_angle=35.0)


def moved_surface(surface: pyvista.DataSet, displacement: np.ndarray) -> pyvista.DataSet:
    """Return a surface whose nodes (n, 3) are displaced."""
    moved = surface.copy()
    moved.points = moved.points + displacement[moved.point_data[NODE]]
    if isinstance(moved, pyvista.PolyData) and IS_SOLID in moved.field_data:
        moved.compute_normals(cell_normals=False, split_vertices=False, inplace=True)
    return moved


def add(plotter: pyvista.Plotter, shown: pyvista.DataSet, **options: Any) -> None:
    """Add a surface with shading; lines and points with fixed sizes."""
    if IS_SOLID in shown.field_data:
        plotter.add_mesh(shown, smooth_shading=True, ambient=0.45, diffuse=0.6, **options)
    else:
        plotter.add_mesh(shown, line_width=5, point_size=8, render_lines_as_tubes=True, **options)


def look(plotter: pyvista.Plotter, view: np.ndarray, zoom: float) -> None:
    """Set the camera to the whole scene from a direction, z upwards."""
    plotter.view_vector(view, viewup=(0.0, 0.0, 1.0))
    plotter.add_axes(color=INK, line_width=2)
    plotter.camera.zoom(zoom)


@contextlib.contextmanager
def plotter_of(size: list[int]) -> Iterator[pyvista.Plotter]:
    """Yield an empty plotter with a size in pixels."""
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="light kit")
    plotter.set_background(PAPER)
    plotter.enable_anti_aliasing("ssaa")
    try:
        yield plotter
    finally:
        plotter.close()


if __name__ == "__main__":
    serve(draw_all)
