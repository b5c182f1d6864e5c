"""Interface to FEniCSx: meshes, spaces and sparse matrices. The only file that imports dolfinx, ufl, basix or mpi4py.

All differences between their versions are handled here: 0.5 (Debian 12), 0.9 (Debian 13), 0.10 and 0.11 (the wheel).
`load` returns a namespace `fx` from which the forms are made (`kanefe_fem.solids.forms`); they are used within `quiet`
and `compiling`.
"""

from __future__ import annotations

import contextlib
import logging
import os
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import FileError, MeshError, MissingDependency, outside
from kanefe.fe_model.shapes import Shape
from kanefe_fem._petsc import start_mpi
from kanefe_fem.machine.compiled_forms import SECONDS, being_compiled, check_forms, forms_folder, refuse_options
from kanefe_fem.processes.launcher import check_launcher

OLDEST, NEWEST = (0, 5), (0, 11)
"""Oldest and newest version of dolfinx with which this file was tested."""

REMEDY = (
    "on Debian or Ubuntu: sudo apt-get install python3-dolfinx, then use /usr/bin/python3 or an environment made by "
    "/usr/bin/python3 -m venv --system-site-packages; elsewhere, with Python >= 3.12: pip install 'kanefe[fenicsx]'"
)

_CELLS = {"triangle": "triangle", "quad": "quadrilateral", "tetra": "tetrahedron", "hexahedron": "hexahedron"}

SHAPES = ("triangle", "quad", "tetra", "hexahedron", "triangle6", "quad9", "tetra10", "hexahedron27")
"""Cell shapes that dolfinx assembles; all cells of a mesh have the same shape."""


def load() -> Any:
    """Import FEniCSx after `start_mpi`, and return a namespace of its modules."""
    start_mpi()
    refuse_options()
    try:
        from mpi4py import MPI  # isort: skip
        import basix
        import dolfinx
        import dolfinx.fem.petsc
        import dolfinx.jit
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
            stacklevel=outside(),
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
        cache=_own_cache(dolfinx.jit),
    )


def world() -> Any:
    """Return the communicator of all processes that mpirun started; of this one alone without mpirun.

    Raises
    ------
    ModelError
        If mpirun is of another MPI than mpi4py.
    """
    start_mpi()
    try:
        from mpi4py import MPI
    except ImportError as problem:
        raise MissingDependency("mpi4py", "kanefe reduce", f"{REMEDY} ({problem})") from problem
    check_launcher(MPI.COMM_WORLD.size, os.environ)
    return MPI.COMM_WORLD


def load_ufl() -> tuple[Any, type[Exception]]:
    """Return only UFL, for expressions without a mesh, and the class of its errors (ValueError since 2024)."""
    try:
        import ufl
    except ImportError as problem:
        raise MissingDependency("ufl", "UserEnergy", f"{REMEDY} ({problem})") from problem
    return ufl, getattr(ufl, "UFLException", ValueError)


def _own_cache(jit: Any) -> Path:
    """Let dolfinx store compiled forms in our folder, unless the user has set another; return the checked folder."""
    defaults = getattr(jit, "DOLFINX_DEFAULT_JIT_OPTIONS", None) or jit.DOLFINX_DEFAULT_JIT_PARAMETERS
    defaults["cache_dir"] = (forms_folder(), defaults["cache_dir"][1])
    defaults["timeout"] = (SECONDS, defaults["timeout"][1])
    arguments, told = defaults["cffi_extra_compile_args"]
    if "-w" not in arguments:  # the C has weights that it does not use, and the compiler says so on the terminal
        defaults["cffi_extra_compile_args"] = ([*arguments, "-w"], told)
    options = (getattr(jit, "get_options", None) or jit.get_parameters)()
    folder = Path(options["cache_dir"])
    check_forms(folder)
    return folder


def _reference_points(fx: Any, element: Shape) -> np.ndarray:
    """Return the points of basix's Lagrange element, in its own node order."""
    cell = getattr(fx.basix.CellType, _CELLS[element.corner_kind])
    variant = fx.basix.LagrangeVariant.equispaced
    made = fx.basix.create_element(fx.basix.ElementFamily.P, cell, element.order, variant)
    return np.asarray(made.points)


def create_mesh(
    fx: Any, nodes: np.ndarray, connectivity: np.ndarray, geometry: Shape, dimension: int | None = None
) -> Any:
    """Return dolfinx's mesh; `nodes` and `connectivity` may have more nodes per cell than the geometry.

    `dimension` is that of space: 3 for a surface that is not plane. Default: that of the cells.
    """
    dimension = geometry.dimension if dimension is None else dimension
    cells = connectivity[:, : len(geometry.nodes)]
    used = np.zeros(len(nodes), dtype=bool)
    used[cells] = True
    cells = (np.cumsum(used) - 1)[cells][:, geometry.match(_reference_points(fx, geometry))]
    x = np.ascontiguousarray(nodes[used][:, :dimension])
    cell = _CELLS[geometry.corner_kind]
    if fx.old:
        shape_of_cell = fx.ufl.Cell(cell, geometric_dimension=dimension)
        lagrange = fx.ufl.FiniteElement("Lagrange", shape_of_cell, geometry.order, variant="equispaced")
        domain = fx.ufl.Mesh(fx.ufl.VectorElement(lagrange, dim=dimension))
        return fx.dolfinx.mesh.create_mesh(fx.comm, cells.astype(np.int64), x, domain)
    import basix.ufl

    variant = fx.basix.LagrangeVariant.equispaced
    shape_of_x = (dimension,)
    coordinate = basix.ufl.element("Lagrange", cell, geometry.order, lagrange_variant=variant, shape=shape_of_x)
    return fx.dolfinx.mesh.create_mesh(fx.comm, cells=cells.astype(np.int64), x=x, e=fx.ufl.Mesh(coordinate))


def lagrange_space(fx: Any, mesh: Any, element: Shape, components: int) -> Any:
    """Return the Lagrange space with so many components (0: scalar)."""
    if fx.old:
        if components:
            return fx.fem.VectorFunctionSpace(mesh, ("Lagrange", element.order), dim=components)
        return fx.fem.FunctionSpace(mesh, ("Lagrange", element.order))
    if components:
        return fx.fem.functionspace(mesh, ("Lagrange", element.order, (components,)))
    return fx.fem.functionspace(mesh, ("Lagrange", element.order))


def bubble_space(fx: Any, mesh: Any) -> Any:
    """Return the space of cubic functions of three components that vanish on the sides of triangles."""
    if fx.old:
        return fx.fem.VectorFunctionSpace(mesh, ("Bubble", 3), dim=3)
    return fx.fem.functionspace(mesh, ("Bubble", 3, (3,)))


def cell_function(fx: Any, mesh: Any, values: np.ndarray) -> Any:
    """Return a function constant on each cell, from values of shape (cells,), or (cells, k) for a vector of k."""
    if values.ndim == 1:
        space = fx.fem.FunctionSpace(mesh, ("DG", 0)) if fx.old else fx.fem.functionspace(mesh, ("DG", 0))
    elif fx.old:
        space = fx.fem.VectorFunctionSpace(mesh, ("DG", 0), dim=values.shape[1])
    else:
        space = fx.fem.functionspace(mesh, ("DG", 0, (values.shape[1],)))
    function = fx.fem.Function(space)
    put_in_cells(function, values)
    return function


def cell_dofs(space: Any, cells: int) -> np.ndarray:
    """Return the (blocked) degree of freedom of each cell, of functions constant on each cell."""
    return _dofmap(space, cells)[:, 0]


def discontinuous_function(fx: Any, mesh: Any, values: np.ndarray, element: Shape) -> Any:
    """Return a function that is a polynomial in each cell, from its values at the cell's nodes, (cells, nodes[, k])."""
    family = ("DG" if element.is_simplex else "DQ", element.order)
    size = values.shape[2:]
    if fx.old:
        made = fx.fem.VectorFunctionSpace(mesh, family, dim=size[0]) if size else fx.fem.FunctionSpace(mesh, family)
    else:
        made = fx.fem.functionspace(mesh, (*family, size) if size else family)
    function = fx.fem.Function(made)
    ordered = values[:, element.match(_reference_points(fx, element))]
    function.x.array.reshape(-1, *size)[_dofmap(made, len(values)).ravel()] = ordered.reshape(-1, *size)
    return function


def put_in_cells(function: Any, values: np.ndarray) -> None:
    """Write other values into a function that is constant on each cell: see `cell_function`."""
    function.x.array.reshape(values.shape)[cell_dofs(function.function_space, len(values))] = values


def _dofmap(space: Any, cells: int) -> np.ndarray:
    """Return the (blocked) degrees of freedom of each cell, shape (cells, nodes per cell)."""
    table = space.dofmap.list
    return np.asarray(getattr(table, "array", table)).reshape(cells, -1)


def node_of_dof(fx: Any, space: Any, connectivity: np.ndarray, element: Shape) -> np.ndarray:
    """Return the node of each (blocked) degree of freedom, from the nodes of the cells, without coordinates."""
    dofs = _dofmap(space, len(connectivity))
    numbering = np.full(dofs.max() + 1, -1)
    numbering[dofs] = connectivity[:, element.match(_reference_points(fx, element))]
    return numbering


def facet_corners(mesh: Any, space: Any, numbering: np.ndarray) -> np.ndarray:
    """Return the nodes at the corners of all facets, in dolfinx's order of both, shape (facets, corners).

    Parameters
    ----------
    mesh : dolfinx mesh
    space : function space of Lagrange elements on it
    numbering : ndarray of int
        Of `node_of_dof` for this space.
    """
    topology, d = mesh.topology, mesh.topology.dim
    topology.create_entities(d - 1)
    for dimension in (d, d - 1):
        topology.create_connectivity(dimension, 0)
    topology.create_connectivity(d - 1, d)
    count = len(np.asarray(topology.original_cell_index))
    vertices = np.asarray(topology.connectivity(d, 0).array).reshape(count, -1)
    facets = topology.connectivity(d - 1, 0)
    node_of_vertex = np.full(vertices.max() + 1, -1)
    node_of_vertex[vertices] = numbering[_dofmap(space, count)[:, : vertices.shape[1]]]
    return node_of_vertex[np.asarray(facets.array).reshape(len(facets.offsets) - 1, -1)]


def tags(fx: Any, mesh: Any, dimension: int, values: np.ndarray) -> Any:
    """Return dolfinx's tags with a value of each entity of a dimension."""
    numbers = np.arange(len(values), dtype=np.int32)
    return fx.dolfinx.mesh.meshtags(mesh, dimension, numbers, values.astype(np.int32))


def check_numbering(space: Any, nodes: np.ndarray, numbering: np.ndarray) -> None:
    """Compare the points of the degrees of freedom with our nodes, since a new version could change their order."""
    points = np.asarray(space.tabulate_dof_coordinates())[: len(numbering)]
    d = space.mesh.geometry.dim
    error = np.abs(points[:, :d] - nodes[numbering][:, :d]).max()
    if not error <= 1e-9 * np.ptp(nodes, axis=0).max():
        raise MeshError(
            f"the nodes of this version of dolfinx are ordered in an unknown way (they differ by {error:.3g} m). "
            f"Remedy: use dolfinx {OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]}"
        )


def compiled_expression(fx: Any, mesh: Any, expression: Any, points: np.ndarray) -> Callable[[int], np.ndarray]:
    """Return a function of the number of cells that evaluates a UFL expression at reference points of each of them."""
    if not fx.ufl.algorithms.extract_coefficients(expression):  # dolfinx 0.11 takes the mesh from these
        expression = cell_function(fx, mesh, np.ones(len(mesh.topology.original_cell_index))) * expression
    made = fx.fem.Expression(expression, np.ascontiguousarray(points))

    def values(cells: int) -> np.ndarray:
        numbers = np.arange(cells, dtype=np.int32)
        return np.asarray(made.eval(numbers) if fx.old else made.eval(mesh, numbers))

    return values


def assemble_rows(fx: Any, forms: Iterable[Any]) -> Any:
    """Return the sum of the matrices of forms on the same spaces, PETSc's, whose rows are spread like the mesh.

    Each form is assembled before the next one is asked for.
    """
    matrix: Any = None
    for form in forms:
        matrix = fx.petsc.create_matrix(form) if matrix is None else matrix
        fx.petsc.assemble_matrix(matrix, form)
    matrix.assemble()
    return matrix


def assemble_matrix(fx: Any, form: Any) -> sp.csr_matrix:
    """Assemble a form and return a copy of the matrix."""
    return assemble_sum(fx, (form,))


def assemble_sum(fx: Any, forms: Iterable[Any]) -> sp.csr_matrix:
    """Return a copy of the sum of the matrices of forms: see `assemble_rows`."""
    matrix = assemble_rows(fx, forms)
    indptr, indices, data = matrix.getValuesCSR()
    csr = sp.csr_matrix((data, indices, indptr), shape=matrix.getSize())
    matrix.destroy()
    return csr


@contextlib.contextmanager
def compiling(fx: Any) -> Iterator[None]:
    """Turn failures of the form compiler into errors with a remedy; store digests of the compiled forms."""
    try:
        with being_compiled(fx.cache):
            yield
    except TimeoutError as problem:
        raise FileError(
            f"another process compiles the same form in {fx.cache}, and has not finished after {SECONDS} s. Remedy: "
            "run this again when it has, or remove that folder"
        ) from problem
    except PermissionError as problem:
        raise FileError(
            f"the compiled forms cannot be written: {problem}. Remedy: set XDG_CACHE_HOME to a folder of yours"
        ) from problem
    except Exception as problem:  # distutils, setuptools and subprocess have different errors
        if "compile" in type(problem).__name__.lower() or "gcc" in str(problem):
            raise MissingDependency(
                "a C compiler", "dolfinx", f"sudo apt-get install gcc libc6-dev ({problem})"
            ) from problem
        raise


# a filter acts on the records of its own logger only, so the logger of setuptools' compiler is needed too
_NOISY = (None, "UFL", "ffcx", "FFCX", "FFCx", "basix", "dolfinx", "compilers.C.base", "distutils", "setuptools")


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress messages of the compiler below WARNING from this thread."""
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
            warnings.filterwarnings("ignore", "Number of integration points")  # of forms on curved bricks
            yield
    finally:
        for logger in loggers:
            logger.removeFilter(important)
