"""Meshes from files of gmsh and of the formats that meshio reads."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from kanefe.arguments import checked
from kanefe.errors import FileError, MeshError
from kanefe.storage.files import regular_file
from kanefe_fem.mesh.checks import check_arrays, check_mesh
from kanefe_fem.mesh.mesh import Mesh, part_of, to_order

GMSH_SUFFIXES = (".msh", ".geo", ".py")

SOURCES = (".geo", ".py")
"""Formats that contain no mesh but a geometry to be meshed."""

GEOMETRY = (".step", ".stp", ".iges", ".igs", ".brep", ".sat", ".x_t", ".sldprt", ".catpart", ".f3d", ".dwg", ".dxf")
"""Formats of drawing programs, which contain no cells and no cell sizes."""


@checked
def read_mesh(
    path: str | Path,
    order: int | None = None,
    *,
    names: Mapping[int, str] | None = None,
    cells: str | Sequence[str] | None = None,
    trusted: bool = False,
) -> Mesh:
    """Read a mesh, or mesh a gmsh source.

    ==============  ====================================================================================
    suffix          how
    ==============  ====================================================================================
    .msh            gmsh (2.2 and 4.1, ascii and binary); groups are the physical groups
    .geo            gmsh, meshed in 3D, or in 2D if the source has no volume; one that runs programs, or reads or
                    writes other files, is refused unless it is `trusted`
    .py             a Python source which defines ``build(gmsh)``: called with gmsh initialised and an empty
                    model; it makes the geometry and the physical groups, and may mesh; else it is meshed here.
                    It is a program, and may do all that a program may: read it before it is run
    .inp            meshio; groups are the element sets that solid sections name (all of them, if none does),
                    the surfaces and the node sets
    any other       meshio (.vtu, .xdmf, .bdf, ...); groups are its cell sets and point sets, else the integers of
                    the cell data "gmsh:physical", "medit:ref", "group", ...
    ==============  ====================================================================================

    A file without groups of cells is one body, the group "body"; its interfaces and loaded surfaces are then chosen by
    their places (`kanefe.Near`, `kanefe.OnPlane`, `kanefe.InBox`, `kanefe.InCylinder`, or a function).

    Parameters
    ----------
    path : str or Path
        File to read; lengths are in m.
    order : int, optional
        Order of the geometry, 1 or 2. A source is meshed with this order (2: the mid-side nodes lie on the curved
        surface); the mesh of a file is converted (to 2: with straight sides). Default: as the file or the source says,
        which is 1 in most; ``mesh.sagitta`` tells how far its straight sides then are from the curves of a source.
    names : dict of int to str, optional
        Names of the groups which the file knows by number only (.vtu, .xdmf). Default: the number itself, as in "1".
    cells : str or sequence of str, optional
        Groups of cells to keep: one body of several in the file (see `kanefe_fem.mesh.mesh.part_of`). Default: all.
    trusted : bool
        Whether a .geo source may run programs and open other files, also by options in a file ``.opt`` beside it or a
        .msh; and whether a file may name others outside its folder (``*INCLUDE`` of Abaqus, data of XDMF).

    Returns
    -------
    Mesh

    Raises
    ------
    FileError
        The file is not there, is truncated or cannot be read, or runs programs or opens other files without being
        trusted; the message names the line.
    MeshError
        The mesh cannot be used; the message names the place and the remedy.
    MissingDependency
        gmsh or meshio is needed and is not installed.

    Notes
    -----
    A physical group without a name is called by its number. As in gmsh, elements of no physical group are left out
    when there are groups; a warning says how many.
    """
    path = Path(path)
    if order not in (None, 1, 2):
        raise MeshError(f"order {order!r} of the geometry of {path.name} is not possible. Remedy: give 1 or 2")
    regular_file(path, kind="mesh file", remedy="check the name and the working directory")
    if path.suffix.lower() in GEOMETRY:
        raise FileError(
            f"{path.name} is a geometry and no mesh: it has no cells, and no size for them. Remedy: mesh it with gmsh, "
            "by a file such as part.py of these lines (STEP, IGES and BREP), and read_mesh('part.py'):\n"
            "def build(gmsh):\n"
            "    gmsh.option.setString('Geometry.OCCTargetUnit', 'M')\n"
            f"    solids = gmsh.model.occ.importShapes({str(path)!r})\n"
            "    gmsh.model.occ.synchronize()\n"
            "    body = gmsh.model.addPhysicalGroup(3, [tag for _, tag in solids])\n"
            "    gmsh.model.setPhysicalName(3, body, 'body')\n"
            "    gmsh.option.setNumber('Mesh.MeshSizeMax', 0.01)  # m"
        )
    if path.suffix.lower() in GMSH_SUFFIXES:
        from kanefe_fem import _gmsh

        mesh = _gmsh.read(path, order, trusted)
    else:
        from kanefe_fem import _meshio

        mesh = _meshio.read(path, names or {}, trusted)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    provenance = {"file": path.name, "sha256": digest, **mesh.provenance}
    mesh = replace(mesh, provenance=provenance)
    mesh = mesh if cells is None else part_of(check_arrays(mesh), cells)
    frame_only = mesh.lines and not mesh.cells  # beams need no group of cells
    mesh = check_arrays(mesh) if frame_only else check_mesh(mesh)
    return mesh if order is None or not mesh.cells else to_order(mesh, order)


def read_to_assemble(path: str | Path, order: int, cells: str | Sequence[str] | None = None) -> Mesh:
    """Return the mesh of a file for elements of some order: quadratic ones follow the curves of a source.

    Raises
    ------
    FileError, MeshError, MissingDependency
        As `read_mesh`.
    """
    is_curved = order == 2 and Path(path).suffix.lower() in SOURCES
    return read_mesh(path, order=2 if is_curved else None, cells=cells)
