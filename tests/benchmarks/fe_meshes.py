"""Meshes of the benchmark: a steel bar of 1 x 0.1 x 0.05 m in straight tetrahedra, by gmsh, as fine as is asked for."""

from __future__ import annotations

import os
from pathlib import Path

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


def bar(folder: Path, size: str) -> Path:
    """Return the mesh file of a size; make it if it is not there. Both sides of a comparison read the same file."""
    path = folder / f"bar_{size}.msh"
    if not path.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = folder / f"unfinished_{os.getpid()}.msh"
        _write(unfinished, SIZES[size])
        os.replace(unfinished, path)
    return path


def _write(path: Path, h: float) -> None:
    import gmsh

    gmsh.initialize(["benchmark"], readConfigFiles=False)
    try:
        for name, value in {
            "General.Terminal": 0,
            "Mesh.Algorithm3D": 10,  # HXT: the fastest, and the same mesh in every run
            "Mesh.CharacteristicLengthMin": h,
            "Mesh.CharacteristicLengthMax": h,
            "Mesh.MshFileVersion": 2.2,  # what the peer reads
        }.items():
            gmsh.option.setNumber(name, value)
        volume = gmsh.model.occ.addBox(0.0, -0.05, -0.025, 1.0, 0.1, 0.05)
        gmsh.model.occ.synchronize()
        gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [volume]), "bar")
        faces = {surface: gmsh.model.occ.getCenterOfMass(2, surface)[0] for _, surface in gmsh.model.getEntities(2)}
        for name, low, high in (("root", -1e-9, 1e-9), ("sides", 1e-9, 1.0 - 1e-9), ("tip", 1.0 - 1e-9, 1.0 + 1e-9)):
            group = gmsh.model.addPhysicalGroup(2, [surface for surface, x in faces.items() if low < x < high])
            gmsh.model.setPhysicalName(2, group, name)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
