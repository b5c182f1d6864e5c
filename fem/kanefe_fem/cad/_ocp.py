"""Door to OCP, the Python interface of OpenCASCADE: names of faces in STEP files, which gmsh does not give."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import MissingDependency

EXTRA = "pip install 'kanefe[cad]'"


class NamedFace(NamedTuple):
    """A face with the name that its file gives it, by what is the same of it in any reader.

    Attributes
    ----------
    name : str
        Empty if it has none.
    area : float
        mm^2.
    centre : ndarray, shape (3,)
        Centroid, mm.
    """

    name: str
    area: float
    centre: np.ndarray


def named_faces(path: Path) -> list[NamedFace]:
    """Return the faces of a STEP file in the order of its parts, in their places in the assembly.

    Raises
    ------
    MissingDependency
        Without OCP.
    """
    ocp = _import_ocp()
    reader = ocp["STEPControl"].STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    entities = reader.WS().TransferReader()
    faces = ocp["TopExp"].TopExp_Explorer(reader.OneShape(), ocp["TopAbs"].TopAbs_FACE)
    found = []
    while faces.More():
        face = faces.Current()
        # a part that is placed several times has one entity, of its shape without a place
        entity = entities.EntityFromShapeResult(face.Located(ocp["TopLoc"].TopLoc_Location()), 1)
        name = entity.Name().ToCString() if hasattr(entity, "Name") else ""
        found.append(NamedFace(name, *_measure(ocp, face)))
        faces.Next()
    return found


def _measure(ocp: dict[str, Any], face: Any) -> tuple[float, np.ndarray]:
    """Return area and centroid of a face."""
    properties = ocp["GProp"].GProp_GProps()
    ocp["BRepGProp"].BRepGProp.SurfaceProperties_s(face, properties)
    centre = properties.CentreOfMass()
    return float(properties.Mass()), np.array((centre.X(), centre.Y(), centre.Z()))


def _import_ocp() -> dict[str, Any]:
    """Return the modules of OCP by name."""
    try:
        from OCP import BRepGProp, GProp, STEPControl, TopAbs, TopExp, TopLoc
    except (ImportError, OSError) as problem:  # OSError: a shared library of the wheel does not load
        raise MissingDependency("OCP", "read_mesh (names of faces in STEP)", f"{EXTRA} ({problem})") from problem
    modules = (BRepGProp, GProp, STEPControl, TopAbs, TopExp, TopLoc)
    return {module.__name__.rpartition(".")[2]: module for module in modules}
