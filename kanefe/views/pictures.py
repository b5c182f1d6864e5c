"""Pictures of meshes without a display: stress fields and mode shapes, drawn by pyvista in a separate process.

In one process, VTK's graphics library and the libraries of dolfinx (MPI, LLVM) can abort each other. VTK may also abort
on a machine without a graphics library: here this becomes an error with a remedy.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import MissingDependency
from kanefe.fe_model.model import CELL_TYPES, Cells
from kanefe.storage.files import write_whole
from kanefe.views.artist import ARTIST


@dataclass(frozen=True, eq=False)
class Drawing:
    """One picture to draw.

    Attributes
    ----------
    draw : {"field", "shape"}
    points : ndarray, shape (n, 3)
    cells : tuple of Cells
    values : ndarray, shape (n,) or (n, 3)
    options : dict
        Keywords of `kanefe.views._pyvista.draw_field` or `draw_shape`, in types of JSON.
    """

    draw: str
    points: np.ndarray
    cells: tuple[Cells, ...]
    values: np.ndarray
    options: dict[str, Any] = field(default_factory=dict)


def write_field(
    path: str | Path,
    points: np.ndarray,
    cells: tuple[Cells, ...],
    values: np.ndarray,
    label: str,
    *,
    view: Sequence[float] = (1.0, -1.3, 0.9),
    title: str | None = None,
    limit: float | None = None,
    size: tuple[int, int] = (1200, 800),
) -> Path:
    """Write a picture of a mesh, coloured by a field; return its path.

    Parameters
    ----------
    path : path
        Of the picture (.png).
    points : ndarray, shape (n, 3)
    cells : tuple of Cells
    values : ndarray, shape (n,)
        At the nodes; NaN is not drawn.
    label : str
        Title of the colour bar, with the unit.
    view : array_like, shape (3,)
        Direction from the mesh to the viewer; z is up.
    title : str, optional
    limit : float, optional
        Value of the last colour. Default: the largest value.
    size : tuple of int
        In pixels.

    Raises
    ------
    FileError, MissingDependency
        If the file cannot be written, or see `drawn`.
    """
    options = {"label": label, "view": [float(x) for x in view], "title": title, "limit": limit, "size": list(size)}
    (image,) = drawn([Drawing("field", points, cells, values, options)])
    write_whole(path, lambda file: file.write(image))
    return Path(path)


def shape_drawing(
    nodes: np.ndarray,
    cells: tuple[Cells, ...],
    displacement: np.ndarray,
    *,
    amplitude: float = 0.12,
    size: tuple[int, int] = (360, 260),
) -> Drawing:
    """Return the drawing of a mode shape: the deformed mesh, coloured by displacement, over the undeformed one.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
    cells : tuple of Cells
    displacement : ndarray, shape (n, 3)
        Of any magnitude.
    amplitude : float
        The largest displacement drawn, relative to the size of the mesh.
    size : tuple of int
        In pixels.
    """
    return Drawing("shape", nodes, cells, displacement, {"amplitude": amplitude, "size": list(size)})


def drawn(drawings: Sequence[Drawing]) -> list[bytes]:
    """Return pictures as the bytes of .png files.

    Raises
    ------
    MissingDependency
        If pyvista is not installed, or has no graphics library to draw with.
    """
    if find_spec("pyvista") is None:
        raise MissingDependency("pyvista", "a picture of a mesh", "pip install 'kanefe[report]'")
    with tempfile.TemporaryDirectory(prefix="kanefe-pictures-") as name:
        folder = Path(name)
        _write_job(folder, drawings)
        if wrong := ARTIST.draw(folder):
            raise MissingDependency(
                "a graphics library that VTK can draw with",
                "a picture of a mesh",
                f"sudo apt-get install libegl1 libgl1-mesa-dri, or pip install -U vtk ({wrong})",
            )
        files = [folder / f"{number}.png" for number in range(len(drawings))]
        return [file.read_bytes() for file in files]


def _write_job(folder: Path, drawings: Sequence[Drawing]) -> None:
    """Write arrays and options; an array that several pictures share is written once."""
    names: dict[int, str] = {}
    arrays: dict[str, np.ndarray] = {}

    def named(array: np.ndarray) -> str:
        if id(array) not in names:
            names[id(array)] = f"a{len(names)}"
            arrays[names[id(array)]] = array
        return names[id(array)]

    jobs = [
        {
            "draw": drawing.draw,
            "points": named(drawing.points),
            "values": named(drawing.values),
            "cells": [(CELL_TYPES[block.kind], named(block.nodes)) for block in drawing.cells],
            "options": drawing.options,
        }
        for drawing in drawings
    ]
    np.savez(folder / "job.npz", **arrays)  # type: ignore[arg-type]
    (folder / "job.json").write_text(json.dumps(jobs), encoding="utf-8")
