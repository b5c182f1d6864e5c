"""Door to FEniCSx: arrays in, sparse matrices out. The only file that imports dolfinx, ufl, basix or mpi4py.

And the only one that knows their versions: 0.5 (Debian 12), 0.9 (Debian 13), 0.10 and 0.11 (the wheel).
"""

from __future__ import annotations

import contextlib
import logging
import os
import tempfile
import threading
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError, MeshError, MissingDependency
from kanefe_fem._petsc import start_mpi
from kanefe_fem.shapes import Shape, kind_of_order, shape

OLDEST, NEWEST = (0, 5), (0, 11)
"""Versions of dolfinx this door was tested with."""

REMEDY = (
    "on Debian or Ubuntu: sudo apt-get install python3-dolfinx, then use /usr/bin/python3 or an environment made by "
    "/usr/bin/python3 -m venv --system-site-packages; elsewhere, with Python >= 3.12: pip install 'kanefe[fenicsx]'"
)

_CELLS = {"triangle": "triangle", "quad": "quadrilateral", "tetra": "tetrahedron", "hexahedron": "hexahedron"}


@dataclass(frozen=True, eq=False)
class Assembly:
    """Matrices in the assembler's own numbering of the nodes.

    Attributes
    ----------
    stiffness : csr_matrix, shape (n d, n d)
        K in N/m, node-major.
    mass : csr_matrix, shape (n, n)
        Scalar mass matrix Ms in kg.
    order_of_nodes : ndarray of int, shape (n,)
        Number, in the arrays given, of each node of the matrices.
    seconds : dict
        Time of each stage.
    versions : dict
        Of dolfinx and PETSc.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    order_of_nodes: np.ndarray
    seconds: dict[str, float]
    versions: dict[str, str]


def assemble(
    nodes: np.ndarray,
    connectivity: np.ndarray,
    kind: str,
    *,
    straight: bool,
    lame: np.ndarray,
    shear: np.ndarray,
    density: np.ndarray,
) -> Assembly:
    """Assemble stiffness and scalar mass of an isotropic linear elastic body.

    ``K_ij = int lambda tr e(N_i) tr e(N_j) + 2 mu e(N_i) : e(N_j)`` and ``Ms_ij = int rho N_i N_j``.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        Nodes of the displacement in m; all are used.
    connectivity : ndarray of int, shape (m, nodes per cell)
        VTK order.
    kind : str
        meshio's name of the cells; its order is that of the displacement.
    straight : bool
        The mid-side nodes are the means of the corners: the geometry is taken of order 1 (faster).
    lame, shear, density : ndarray, shape (m,)
        lambda and mu in Pa, rho in kg/m3 of each cell (times the thickness in 2D).

    Notes
    -----
    The material is a function constant on each cell, so one compiled kernel serves all values and all groups. The mass
    is integrated exactly.
    """
    fx = _load()
    with _quiet(), _compiling():
        return _assemble(fx, nodes, connectivity, kind, straight, (lame, shear, density))


def _assemble(
    fx: Any,
    nodes: np.ndarray,
    connectivity: np.ndarray,
    kind: str,
    straight: bool,
    fields: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> Assembly:
    clock = [time.perf_counter()]
    element = shape(kind)
    geometry = shape(kind_of_order(kind, 1)) if straight else element
    mesh = _create_mesh(fx, nodes, connectivity, geometry)
    original = np.asarray(mesh.topology.original_cell_index)
    clock.append(time.perf_counter())

    vector = _space(fx, mesh, element, element.dimension)
    scalar = _space(fx, mesh, element, 0)
    lame, shear, density = (_cell_function(fx, mesh, values[original]) for values in fields)
    u, v = fx.ufl.TrialFunction(vector), fx.ufl.TestFunction(vector)
    p, q = fx.ufl.TrialFunction(scalar), fx.ufl.TestFunction(scalar)
    strain_u, strain_v = fx.ufl.sym(fx.ufl.grad(u)), fx.ufl.sym(fx.ufl.grad(v))
    energy = lame * fx.ufl.tr(strain_u) * fx.ufl.tr(strain_v) + 2.0 * shear * fx.ufl.inner(strain_u, strain_v)
    dx = fx.ufl.Measure("dx", domain=mesh)
    stiffness_form = fx.fem.form(energy * dx(metadata={"quadrature_degree": stiffness_degree(element, geometry)}))
    mass_form = fx.fem.form(density * p * q * dx(metadata={"quadrature_degree": mass_degree(element, geometry)}))
    clock.append(time.perf_counter())

    stiffness = _matrix(fx, stiffness_form)
    clock.append(time.perf_counter())
    mass = _matrix(fx, mass_form)
    clock.append(time.perf_counter())

    numbering = _node_of_dof(fx, vector, connectivity[original], element)
    numbering_of_mass = _node_of_dof(fx, scalar, connectivity[original], element)
    if not np.array_equal(numbering, numbering_of_mass):
        to_vector = np.argsort(numbering_of_mass)[numbering]
        mass = mass[to_vector][:, to_vector]
    _check_numbering(vector, nodes, numbering)
    stages = ("create mesh", "compile forms", "assemble stiffness", "assemble mass")
    seconds = dict(zip(stages, np.diff(clock).tolist(), strict=True))
    return Assembly(stiffness, mass, numbering, seconds, fx.versions)


def mass_degree(element: Shape, geometry: Shape) -> int:
    """Degree that integrates the mass exactly: total on simplices, in each direction on cubes."""
    d = element.dimension
    if element.is_simplex:
        return 2 * element.order + d * (geometry.order - 1)
    return 2 * element.order + d * geometry.order - 1


def stiffness_degree(element: Shape, geometry: Shape) -> int:
    """Degree of quadrature of the stiffness: exact on straight simplices and on boxes."""
    if element.is_simplex:
        return 2 * (element.order - 1) + 2 * (geometry.order - 1)
    return 2 * element.order


def _load() -> Any:
    """Import FEniCSx, once MPI is made safe, and return what the assembly needs of it."""
    start_mpi()
    cache = _make_cache_writable()
    try:
        from mpi4py import MPI  # isort: skip
        import basix
        import dolfinx
        import dolfinx.fem.petsc
        import ufl
        from petsc4py import PETSc
    except ImportError as problem:
        raise MissingDependency("dolfinx", "solid_model", f"{REMEDY} ({problem})") from problem
    version = tuple(int(part) for part in dolfinx.__version__.split(".")[:2])
    if not OLDEST <= version <= NEWEST:
        warnings.warn(
            f"dolfinx {dolfinx.__version__} is outside the tested range {OLDEST[0]}.{OLDEST[1]} to "
            f"{NEWEST[0]}.{NEWEST[1]}; the numbering of its nodes is checked, the rest is not",
            UserWarning,
            stacklevel=4,
        )
    versions = {"dolfinx": dolfinx.__version__, "PETSc": ".".join(str(part) for part in PETSc.Sys.getVersion())}
    return SimpleNamespace(
        comm=MPI.COMM_SELF,
        basix=basix,
        dolfinx=dolfinx,
        fem=dolfinx.fem,
        petsc=dolfinx.fem.petsc,
        ufl=ufl,
        old=version < (0, 8),
        versions=versions,
        cache=cache,
    )


def _make_cache_writable() -> Path:
    """Return the folder of compiled forms; choose a temporary one if the usual one cannot be written."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "fenics"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as problem:
        spare = Path(tempfile.gettempdir()) / f"kanefe-cache-{os.getuid()}"
        spare.mkdir(mode=0o700, exist_ok=True)
        os.environ["XDG_CACHE_HOME"] = str(spare)
        warnings.warn(
            f"the cache of compiled forms {folder} cannot be written ({problem}); using {spare}. "
            "Set XDG_CACHE_HOME to a folder of yours to keep them",
            UserWarning,
            stacklevel=5,
        )
        return spare / "fenics"


def _reference_points(fx: Any, element: Shape) -> np.ndarray:
    """Return the points of basix's Lagrange element, in its own node order."""
    cell = getattr(fx.basix.CellType, _CELLS[element.corner_kind])
    variant = fx.basix.LagrangeVariant.equispaced
    made = fx.basix.create_element(fx.basix.ElementFamily.P, cell, element.order, variant)
    return np.asarray(made.points)


def _create_mesh(fx: Any, nodes: np.ndarray, connectivity: np.ndarray, geometry: Shape) -> Any:
    """Return dolfinx's mesh; `nodes` and `connectivity` may carry more nodes a cell than the geometry has."""
    cells = connectivity[:, : len(geometry.nodes)]
    used = np.zeros(len(nodes), dtype=bool)
    used[cells] = True
    cells = (np.cumsum(used) - 1)[cells][:, geometry.match(_reference_points(fx, geometry))]
    x = np.ascontiguousarray(nodes[used][:, : geometry.dimension])
    cell = _CELLS[geometry.corner_kind]
    if fx.old:
        lagrange = fx.ufl.FiniteElement("Lagrange", cell, geometry.order, variant="equispaced")
        domain = fx.ufl.Mesh(fx.ufl.VectorElement(lagrange))
        return fx.dolfinx.mesh.create_mesh(fx.comm, cells.astype(np.int64), x, domain)
    import basix.ufl

    variant = fx.basix.LagrangeVariant.equispaced
    shape_of_x = (geometry.dimension,)
    coordinate = basix.ufl.element("Lagrange", cell, geometry.order, lagrange_variant=variant, shape=shape_of_x)
    return fx.dolfinx.mesh.create_mesh(fx.comm, cells=cells.astype(np.int64), x=x, e=fx.ufl.Mesh(coordinate))


def _space(fx: Any, mesh: Any, element: Shape, components: int) -> Any:
    """Return the Lagrange space with so many components (0: scalar)."""
    if fx.old:
        if components:
            return fx.fem.VectorFunctionSpace(mesh, ("Lagrange", element.order), dim=components)
        return fx.fem.FunctionSpace(mesh, ("Lagrange", element.order))
    if components:
        return fx.fem.functionspace(mesh, ("Lagrange", element.order, (components,)))
    return fx.fem.functionspace(mesh, ("Lagrange", element.order))


def _cell_function(fx: Any, mesh: Any, values: np.ndarray) -> Any:
    """Return a function constant on each cell."""
    space = fx.fem.FunctionSpace(mesh, ("DG", 0)) if fx.old else fx.fem.functionspace(mesh, ("DG", 0))
    function = fx.fem.Function(space)
    function.x.array[_dofmap(space, len(values))[:, 0]] = values
    return function


def _dofmap(space: Any, cells: int) -> np.ndarray:
    """Return the (blocked) degrees of freedom of each cell, shape (cells, nodes per cell)."""
    table = space.dofmap.list
    return np.asarray(getattr(table, "array", table)).reshape(cells, -1)


def _node_of_dof(fx: Any, space: Any, connectivity: np.ndarray, element: Shape) -> np.ndarray:
    """Return the node of each (blocked) degree of freedom; cells and their nodes say it, not coordinates."""
    dofs = _dofmap(space, len(connectivity))
    numbering = np.full(dofs.max() + 1, -1)
    numbering[dofs] = connectivity[:, element.match(_reference_points(fx, element))]
    return numbering


def _check_numbering(space: Any, nodes: np.ndarray, numbering: np.ndarray) -> None:
    """Compare the points of the degrees of freedom with our nodes: a new version could order them otherwise."""
    points = np.asarray(space.tabulate_dof_coordinates())[: len(numbering)]
    d = space.mesh.geometry.dim
    error = np.abs(points[:, :d] - nodes[numbering][:, :d]).max()
    if not error <= 1e-9 * np.ptp(nodes, axis=0).max():
        raise MeshError(
            f"the nodes of this version of dolfinx are ordered in an unknown way (they differ by {error:.3g} m). "
            f"Remedy: use dolfinx {OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]}"
        )


def _matrix(fx: Any, form: Any) -> sp.csr_matrix:
    """Assemble a form and return a copy of the matrix."""
    matrix = fx.petsc.assemble_matrix(form)
    matrix.assemble()
    indptr, indices, data = matrix.getValuesCSR()
    csr = sp.csr_matrix((data, indices, indptr), shape=matrix.getSize())
    matrix.destroy()
    return csr


@contextlib.contextmanager
def _compiling() -> Iterator[None]:
    """Turn the failures of the form compiler into errors with a remedy."""
    try:
        yield
    except PermissionError as problem:
        raise FileError(
            f"the compiled forms cannot be written: {problem}. Remedy: set XDG_CACHE_HOME to a folder of yours"
        ) from problem
    except Exception as problem:  # distutils, setuptools and subprocess each have an error of their own
        if "compile" in type(problem).__name__.lower() or "gcc" in str(problem):
            raise MissingDependency(
                "a C compiler", "dolfinx", f"sudo apt-get install gcc libc6-dev ({problem})"
            ) from problem
        raise


# A filter acts on records of its own logger only, so that of setuptools' compiler has to be named too.
_NOISY = (None, "UFL", "ffcx", "FFCX", "FFCx", "basix", "dolfinx", "compilers.C.base", "distutils", "setuptools")


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep the compiler's chatter (below WARNING, from this thread) off the user's loggers."""
    me = threading.get_ident()

    def important(record: logging.LogRecord) -> bool:
        return record.levelno >= logging.WARNING or record.thread != me

    loggers = [logging.getLogger(name) for name in _NOISY]
    for logger in loggers:
        logger.addFilter(important)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)
            warnings.simplefilter("ignore", DeprecationWarning)
            yield
    finally:
        for logger in loggers:
            logger.removeFilter(important)
