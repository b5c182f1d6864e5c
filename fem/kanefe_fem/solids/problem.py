"""A solid on its mesh in FEniCSx: spaces, material, and the assembly of stiffness, mass and geometric stiffness."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import StressStiffness
from kanefe.fe_model.shapes import Shape, kind_of_order, shape
from kanefe_fem import _fenicsx
from kanefe_fem.materials.moduli import Moduli
from kanefe_fem.solids import forms as solid_forms
from kanefe_fem.solids.forms import MaterialFields, stiffness_degree


@dataclass(frozen=True, eq=False)
class SolidProblem:
    """The data of a solid for further forms.

    Attributes
    ----------
    fx : namespace
        From `kanefe_fem._fenicsx.load`.
    mesh : dolfinx mesh
    vector, scalar : function spaces
        The space of the displacement, and the scalar space of the same order.
    fields : MaterialFields
        The moduli, times the thickness in 2D.
    element, geometry : Shape
        Shapes of the displacement and of the mesh, for the degrees of quadrature.
    order_of_nodes : ndarray of int, shape (n,)
        Number, in the given arrays, of each node of the matrices.
    scalar_order : ndarray of int, shape (n,), or None
        Degree of freedom of the scalar space of each node of the matrices. None: the same number.
    """

    fx: Any
    mesh: Any
    vector: Any
    scalar: Any
    fields: MaterialFields
    element: Shape
    geometry: Shape
    order_of_nodes: np.ndarray
    scalar_order: np.ndarray | None

    def displacement(self, u: np.ndarray) -> Any:
        """Return the function with the displacements u (n d,) in m, in the order of the matrices."""
        function = self.fx.fem.Function(self.vector)
        function.x.array[:] = u
        return function

    def stress(self, u: Any) -> Any:
        """Return the stress of a displacement as a UFL tensor, in Pa (N/m in 2D)."""
        return solid_forms.stress(self.fx, self.fields, u)

    def measure(self, degree: int) -> Any:
        """Return dx of the mesh with a quadrature exact to the degree."""
        return self.fx.ufl.Measure("dx", domain=self.mesh)(metadata={"quadrature_degree": degree})

    def scalar_matrix(self, form: Any) -> sp.csr_matrix:
        """Return the matrix of a compiled form on the scalar space, in the order of the nodes of the matrices."""
        matrix = _fenicsx.assemble_matrix(self.fx, form)
        if self.scalar_order is None:
            return matrix
        return matrix[self.scalar_order][:, self.scalar_order]


class CompiledForms(NamedTuple):
    """The compiled forms of an assembly, for the same with other numbers on the cells.

    Attributes
    ----------
    stiffness, mass : compiled form
    density : function of the mesh
    original : ndarray of int, shape (m,)
        Number, in the given arrays, of each cell of the mesh.
    """

    stiffness: Any
    mass: Any
    density: Any
    original: np.ndarray


@dataclass(frozen=True, eq=False)
class Assembly:
    """Matrices in the assembler's own numbering of the nodes.

    Attributes
    ----------
    stiffness : csr_matrix, shape (n d, n d)
        K in N/m, node-major.
    mass : csr_matrix, shape (n, n)
        Scalar mass matrix Ms in kg.
    problem : SolidProblem
    seconds : dict
        Time of each stage.
    versions : dict
        Versions of dolfinx and PETSc.
    forms : CompiledForms
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    problem: SolidProblem
    seconds: dict[str, float]
    versions: dict[str, str]
    forms: CompiledForms

    @property
    def order_of_nodes(self) -> np.ndarray:
        """Number, in the given arrays, of each node of the matrices, shape (n,)."""
        return self.problem.order_of_nodes

    @property
    def stress_stiffness(self) -> StressStiffness:
        """Function of the geometric stiffness of a static displacement."""
        return solid_stress_stiffness(self.problem)

    def stiffness_with(self, moduli: Moduli) -> sp.csr_matrix:
        """Return the stiffness with other moduli of the same kind; its own are there again afterwards."""
        functions = self.problem.fields.functions
        own = [function.x.array.copy() for function in functions]
        for function, values in zip(functions, solid_forms.values_of(moduli, self.forms.original), strict=True):
            _fenicsx.put_in_cells(function, values)
        found = _fenicsx.assemble_matrix(self.problem.fx, self.forms.stiffness)
        for function, values in zip(functions, own, strict=True):
            function.x.array[:] = values
        return without_zeros(found)

    def mass_with(self, density: np.ndarray) -> sp.csr_matrix:
        """Return the scalar mass matrix with other densities (m,), such as those times factors of their damping."""
        _fenicsx.put_in_cells(self.forms.density, density[self.forms.original])
        return self.problem.scalar_matrix(self.forms.mass)


def without_zeros(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """Return a matrix without the zeros of cells that have no part in it."""
    matrix.eliminate_zeros()
    return matrix


def assemble(
    nodes: np.ndarray, connectivity: np.ndarray, kind: str, *, straight: bool, moduli: Moduli, density: np.ndarray
) -> Assembly:
    """Assemble stiffness and scalar mass of a linear elastic body.

    ``K_ij = int s(N_i) : e(N_j)`` with ``s = lambda tr(e) I + 2 mu e`` or ``C : e``, and ``Ms_ij = int rho N_i N_j``.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        Nodes of the displacement in m; all are used.
    connectivity : ndarray of int, shape (m, nodes per cell)
        VTK order.
    kind : str
        meshio's name of the cells; its order is that of the displacement.
    straight : bool
        Whether the mid-side nodes are the means of the corners: the geometry is then of order 1 (faster).
    moduli : IsotropicModuli or AnisotropicModuli
        Moduli of each cell.
    density : ndarray, shape (m,)
        rho of each cell in kg/m3 (times the thickness in 2D).

    Notes
    -----
    The mass is integrated exactly.
    """
    fx = _fenicsx.load()
    with _fenicsx.quiet(), _fenicsx.compiling(fx):
        return _assemble(fx, nodes, connectivity, kind, straight, moduli, density)


def _assemble(
    fx: Any,
    nodes: np.ndarray,
    connectivity: np.ndarray,
    kind: str,
    straight: bool,
    moduli: Moduli,
    density: np.ndarray,
) -> Assembly:
    clock = [time.perf_counter()]
    problem = solid_problem(fx, nodes, connectivity, kind, straight)
    original = np.asarray(problem.mesh.topology.original_cell_index)
    clock.append(time.perf_counter())

    fields = solid_forms.material_fields(fx, problem.mesh, moduli, original)
    problem = replace(problem, fields=fields)
    rho = _fenicsx.cell_function(fx, problem.mesh, density[original])
    forms = stiffness_and_mass(problem, rho)
    stiffness_form, mass_form = (fx.fem.form(one) for one in forms)
    clock.append(time.perf_counter())

    stiffness = _fenicsx.assemble_matrix(fx, stiffness_form)
    clock.append(time.perf_counter())
    mass = problem.scalar_matrix(mass_form)
    clock.append(time.perf_counter())

    stages = ("create mesh", "compile forms", "assemble stiffness", "assemble mass")
    seconds = dict(zip(stages, np.diff(clock).tolist(), strict=True))
    return Assembly(
        stiffness, mass, problem, seconds, fx.versions, CompiledForms(stiffness_form, mass_form, rho, original)
    )


def stiffness_and_mass(problem: SolidProblem, density: Any) -> tuple[Any, Any]:
    """Return the forms of the stiffness and of the scalar mass, in UFL; the density is a function of the mesh."""
    ufl, element, geometry = problem.fx.ufl, problem.element, problem.geometry
    u, v = ufl.TrialFunction(problem.vector), ufl.TestFunction(problem.vector)
    p, q = ufl.TrialFunction(problem.scalar), ufl.TestFunction(problem.scalar)
    energy = solid_forms.stiffness_integrand(problem.fx, problem.fields, u, v)
    stiffness = energy * problem.measure(solid_forms.stiffness_degree(element, geometry))
    return stiffness, density * p * q * problem.measure(solid_forms.mass_degree(element, geometry))


def solid_problem(fx: Any, nodes: np.ndarray, connectivity: np.ndarray, kind: str, straight: bool) -> SolidProblem:
    """Return the spaces on a mesh, still without moduli; the arguments are those of `assemble`."""
    element = shape(kind)
    geometry = shape(kind_of_order(kind, 1)) if straight else element
    mesh = _fenicsx.create_mesh(fx, nodes, connectivity, geometry)
    cells = connectivity[np.asarray(mesh.topology.original_cell_index)]
    vector = _fenicsx.lagrange_space(fx, mesh, element, element.dimension)
    scalar = _fenicsx.lagrange_space(fx, mesh, element, 0)
    numbering = _fenicsx.node_of_dof(fx, vector, cells, element)
    numbering_of_scalar = _fenicsx.node_of_dof(fx, scalar, cells, element)
    _fenicsx.check_numbering(vector, nodes, numbering)
    same = np.array_equal(numbering, numbering_of_scalar)
    scalar_order = None if same else np.argsort(numbering_of_scalar)[numbering]
    none = MaterialFields(())
    return SolidProblem(fx, mesh, vector, scalar, none, element, geometry, numbering, scalar_order)


def solid_stress_stiffness(problem: SolidProblem, stress: Callable[[Any], Any] | None = None) -> StressStiffness:
    """Return the geometric stiffness (N, N) of the stress s of a static displacement (N,), as a function of the latter.

    ``K_g = int grad(u) s : grad(v)`` is the same for each component of the displacement, so that only a matrix of the
    scalar space, ``int grad(p) . s grad(q)``, is assembled. Its form is compiled at the first call.

    Parameters
    ----------
    problem : SolidProblem
        2D or 3D; in 2D the stress is per width (times the thickness).
    stress : callable, optional
        Stress of a displacement, in UFL, if it is not that of the problem; integrated by UFL's own degree.
    """
    made: list[tuple[Any, Any]] = []
    dimension = problem.element.dimension

    def geometric_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        with _fenicsx.quiet(), _fenicsx.compiling(problem.fx):
            if not made:
                made.append(form_of_stress(problem, stress))
            loaded, form = made[0]
            loaded.x.array[:] = displacement
            scalar = problem.scalar_matrix(form)
        return sp.kron(scalar, sp.identity(dimension), format="csr")

    return geometric_stiffness


def form_of_stress(problem: SolidProblem, stress: Callable[[Any], Any] | None = None) -> tuple[Any, Any]:
    """Return the function with the static displacement, and the compiled form; see `solid_stress_stiffness`."""
    ufl = problem.fx.ufl
    loaded = problem.displacement(np.zeros(len(problem.order_of_nodes) * problem.element.dimension))
    p, q = ufl.TrialFunction(problem.scalar), ufl.TestFunction(problem.scalar)
    # the quadrature of the stiffness, so that a strain that vanishes at its points, as in a rigid rotation, has no work
    measure = problem.measure(stiffness_degree(problem.element, problem.geometry))
    if stress is not None:
        measure = ufl.Measure("dx", domain=problem.mesh)
    of_loaded = problem.stress(loaded) if stress is None else stress(loaded)
    return loaded, problem.fx.fem.form(ufl.inner(ufl.dot(of_loaded, ufl.grad(p)), ufl.grad(q)) * measure)
