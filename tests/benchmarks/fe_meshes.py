"""Meshes of the benchmark, by gmsh, as fine as is asked for.

A steel bar of 1 x 0.1 x 0.05 m in straight tetrahedra, and a sheet that is bent about its length: 1 m long, an arc of
two radians of 0.25 m, in triangles of second order.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from math import cos, sin
from pathlib import Path
from typing import Any

SIZES = {
    "0.7k": 0.155,
    "1.5k": 0.0935,
    "3k": 0.035,
    "25k": 0.0177,
    "105k": 0.01015,
    "270k": 0.00715,
    "300k": 0.0069,
    "870k": 0.00475,
}
"""Size of the elements in m, by the degrees of freedom of quadratic displacements."""

SIZES_OF_SHEETS = {"3k": 0.07, "105k": 0.0118}
"""Likewise, of six degrees of freedom a node."""

ALGORITHM_3D, ORDER = "Mesh.Algorithm3D", "Mesh.ElementOrder"


def bar(folder: Path, size: str) -> Path:
    """Return the mesh file of a size; make it if it is not there. Both sides of a comparison read the same file."""
    # HXT: the fastest, and the same mesh in every run
    return _file(folder / f"bar_{size}.msh", SIZES[size], {ALGORITHM_3D: 10}, _bar)


def sheet(folder: Path, size: str) -> Path:
    """Return the mesh file of a bent sheet of a size; make it if it is not there."""
    return _file(folder / f"sheet_{size}.msh", SIZES_OF_SHEETS[size], {ORDER: 2}, _sheet)


def _file(path: Path, h: float, options: dict[str, float], shape: Callable[[Any], int]) -> Path:
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f"unfinished_{os.getpid()}.msh")
        _write(unfinished, h, options, shape)
        os.replace(unfinished, path)
    return path


def _write(path: Path, h: float, options: dict[str, float], shape: Callable[[Any], int]) -> None:
    import gmsh

    gmsh.initialize(["benchmark"], readConfigFiles=False)
    try:
        for name, value in {
            "General.Terminal": 0,
            "Mesh.CharacteristicLengthMin": h,
            "Mesh.CharacteristicLengthMax": h,
            "Mesh.MshFileVersion": 2.2,  # what the peer reads
            **options,
        }.items():
            gmsh.option.setNumber(name, value)
        dimension = shape(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        whole = [number for _, number in gmsh.model.getEntities(dimension)]
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, whole), "bar")
        sides = gmsh.model.getEntities(dimension - 1)
        places = {number: gmsh.model.occ.getCenterOfMass(dimension - 1, number)[0] for _, number in sides}
        for name, low, high in (("root", -1e-9, 1e-9), ("sides", 1e-9, 1.0 - 1e-9), ("tip", 1.0 - 1e-9, 1.0 + 1e-9)):
            group = gmsh.model.addPhysicalGroup(dimension - 1, [one for one, x in places.items() if low < x < high])
            gmsh.model.setPhysicalName(dimension - 1, group, name)
        gmsh.model.mesh.generate(dimension)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def _bar(occ: Any) -> int:
    occ.addBox(0.0, -0.05, -0.025, 1.0, 0.1, 0.05)
    return 3


def _sheet(occ: Any) -> int:
    centre, *ends = (occ.addPoint(0.0, 0.25 * sin(a), 0.25 * cos(a) * (a != 0.0)) for a in (0.0, -1.0, 1.0))
    occ.extrude([(1, occ.addCircleArc(ends[0], centre, ends[1]))], 1.0, 0.0, 0.0)
    return 2
