"""Meshes from files of gmsh and of the formats that meshio reads."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from kanefe.arguments import checked
from kanefe.errors import FileError, MeshError
from kanefe.storage.files import regular_file
from kanefe_fem.cad.geometry import GeometryKeywords, mesh_of_geometry
from kanefe_fem.mesh.checks import check_arrays, check_mesh
from kanefe_fem.mesh.groups import has_surfaces_beside
from kanefe_fem.mesh.mesh import Mesh, part_of, to_order

GMSH_SUFFIXES = (".msh", ".geo", ".py")

SOURCES = (".geo", ".py")
"""Formats that contain no mesh but a geometry to be meshed."""

NASTRAN = (".bdf", ".fem", ".nas")
"""Suffixes of Nastran decks."""

GEOMETRY = (".step", ".stp", ".brep")
"""Formats of CAD programs whose solids are meshed."""

OTHER_GEOMETRY = (".iges", ".igs", ".sat", ".x_t", ".sldprt", ".catpart", ".f3d", ".dwg", ".dxf")
"""Formats of CAD programs that are not read."""


@checked
def read_mesh(
    path: str | Path,
    order: int | None = None,
    *,
    names: Mapping[int, str] | None = None,
    cells: str | Sequence[str] | None = None,
    trusted: bool = False,
    **geometry: Unpack[GeometryKeywords],
) -> Mesh:
    """Read a mesh, or make it from a gmsh source or the geometry of a CAD program.

    ==============  ====================================================================================
    suffix          how
    ==============  ====================================================================================
    .msh            gmsh (2.2 and 4.1, ascii and binary); groups are the physical groups
    .geo            gmsh, meshed in 3D, or in 2D if the source has no volume; one that runs programs, or reads or
                    writes other files, is refused unless it is `trusted`
    .py             a Python source that defines ``build(gmsh)``: called with gmsh initialised and an empty
                    model; it makes the geometry and the physical groups, and may generate the mesh, which is
                    generated afterwards otherwise. It runs as a program: read it before you run it
    .step .stp      solids of a CAD program, meshed by gmsh's OpenCASCADE in a process of its own; groups of cells
    .brep           are the parts, groups of facets those of `faces`, and the colours of faces ("#cc8000") of a part
                    that has more than one
    .inp            Abaqus and CalculiX; groups are the element sets of solid sections (all sets, if there are
                    none), the surfaces and the node sets; of several instances they are called INSTANCE.SET
    .bdf .nas .fem  Nastran; groups are the properties, by number
    .unv            I-DEAS, Salome and others; groups of elements and nodes, by name; lengths by its units
    any other       meshio (.vtu, .xdmf, .med, ...); groups are its cell sets and point sets, or the integers of
                    the cell data "gmsh:physical", "medit:ref", "group", ...
    ==============  ====================================================================================

    A file without groups of cells is one body, the group "body". Its interfaces and loaded surfaces can be chosen by
    places (`kanefe.Near`, `kanefe.OnPlane`, `kanefe.InBox`, `kanefe.InCylinder`, or a function).

    Parameters
    ----------
    path : str or Path
        File to read; lengths are in m.
    order : int, optional
        Order of the geometry, 1 or 2. A source is meshed with this order (with 2, the mid-side nodes lie on the curved
        surface); the mesh of a file is converted (to 2 with straight sides). Default: the order of the file or the
        source, mostly 1; ``mesh.sagitta`` is the distance of its straight sides from the curves of a source.
    names : dict of int to str, optional
        Names of the groups that have only numbers in the file (.vtu, .xdmf). Default: the number itself, as in "1".
    cells : str or sequence of str, optional
        Groups of cells to keep: one of several bodies in the file (see `kanefe_fem.mesh.mesh.part_of`). Default: all.
    trusted : bool
        Whether a .geo source may run programs and open other files, also by options in a file ``.opt`` beside it or
        beside a .msh, and whether a file may refer to others outside its folder (``*INCLUDE`` of Abaqus, data of XDMF).
    size : float or dict of str to float
        Of STEP and BREP: largest side of a cell in m; or by name of parts, of their colours and of groups of `faces`,
        with "*" for all other parts.
    per_turn : int
        Of STEP and BREP: cells around a full turn of curved faces, where that makes them smaller than `size`, down to a
        tenth.
    unit : {"um", "mm", "cm", "m", "km", "in", "ft"}
        Of the numbers of a STEP or BREP file. Default: what the STEP file says; a BREP file says nothing.
    faces : dict of str to Near, OnPlane, InBox, InCylinder or function
        Of STEP and BREP: groups of facets by place. A face is in a group if all of it lies in the place.
    joined : bool
        Of STEP and BREP: whether parts that touch are one body, whose cells share the nodes there. Without it a mesh is
        of one part, which `cells` names.
    midsurface : bool
        Of STEP and BREP: whether to mesh the middle surface of a thin part, for `kanefe_fem.shell_body`, with
        `Mesh.thickness`: of pairs of parallel planes and of cylinders on one axis, each of one distance. Faces of the
        sheet in `faces` make a group of cells, faces of its rim a group of lines. Default order: 2.
    most_seconds : float
        Of STEP and BREP: time after which the mesher is stopped. Ctrl-C stops it too.

    Returns
    -------
    Mesh

    Raises
    ------
    FileError
        If the file does not exist, is truncated or cannot be read, or if it runs programs or opens other files without
        being trusted; the message names the line.
    MeshError
        If the mesh cannot be used; the message names the place and the remedy.
    MissingDependency
        If gmsh or meshio is needed and not installed.

    Notes
    -----
    The name of a physical group without a name is its number. If there are physical groups, elements of none are left
    out, as in gmsh; a warning gives their number.
    """
    path = Path(path)
    if order not in (None, 1, 2):
        raise MeshError(f"order {order!r} of the geometry of {path.name} is not possible. Remedy: give 1 or 2")
    regular_file(path, kind="mesh file", remedy="check the name and the working directory")
    suffix = path.suffix.lower()
    if suffix in OTHER_GEOMETRY:
        raise FileError(f"{path.name} is a geometry of another program. Remedy: export it as STEP (AP214 or AP242)")
    if geometry and suffix not in GEOMETRY:
        raise MeshError(
            f"{path.name} is no STEP or BREP file, so {next(iter(geometry))}= has no meaning. Remedy: set sizes and "
            "units where the mesh is made; groups by place: mesh.with_groups(...)"
        )
    if suffix in GEOMETRY:
        mesh, cells = mesh_of_geometry(path, order, cells, geometry), None
    elif suffix in GMSH_SUFFIXES:
        from kanefe_fem import _gmsh

        mesh = _gmsh.read(path, order, trusted)
    elif suffix == ".inp":
        from kanefe_fem.mesh.abaqus_deck import read_abaqus_mesh

        mesh = read_abaqus_mesh(path, trusted)
    elif suffix in (".unv", ".uff"):
        from kanefe_fem.mesh.universal_file import read_universal_mesh

        mesh = read_universal_mesh(path)
    elif suffix in NASTRAN:
        from kanefe_fem.mesh.nastran_deck import read_nastran_mesh

        mesh = read_nastran_mesh(path, names or {}, trusted)
    else:
        from kanefe_fem import _meshio

        mesh = _meshio.read(path, names or {}, trusted)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    mesh = replace(mesh, provenance={"file": path.name, "sha256": digest, **mesh.provenance})
    mesh = mesh if cells is None else part_of(check_arrays(mesh), cells)
    is_frame = mesh.lines and not mesh.cells  # beams need no group of cells
    mesh = check_arrays(mesh) if is_frame else check_mesh(mesh)
    if order is None or not mesh.cells or (mesh.order == order and has_surfaces_beside(mesh)):
        return mesh
    return to_order(mesh, order)


def read_to_assemble(mesh: Mesh | str | Path, order: int, cells: str | Sequence[str] | None = None) -> Mesh:
    """Return a checked mesh, or that of a file, for elements of an order: quadratic ones follow the curves of a source.

    Raises
    ------
    FileError, MeshError, MissingDependency
        As `read_mesh`.
    """
    if isinstance(mesh, Mesh):
        return check_mesh(mesh if cells is None else part_of(check_arrays(mesh), cells))
    is_curved = order == 2 and Path(mesh).suffix.lower() in SOURCES
    return read_mesh(mesh, order=2 if is_curved else None, cells=cells)
