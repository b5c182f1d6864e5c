"""Forms of the user for a solid, in UFL: stress, stiffness, mass, damping, geometric stiffness, added mass.

A form replaces that of the materials, which its function can take and extend. All are assembled on the nodes of the
body by dolfinx, and checked (`kanefe_fem.solids.form_checks`) before the body is reduced.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.geometric_stiffness import check_geometric_stiffness
from kanefe.fe_model.model import Elasticity, FiniteElementModel, StressStiffness
from kanefe_fem import _fenicsx
from kanefe_fem._petsc import factorise
from kanefe_fem.materials.of_groups import CellMaterials
from kanefe_fem.materials.voigt import in_space
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.solids.form_checks import check_damping, check_fluid, check_mass, check_stiffness
from kanefe_fem.solids.form_terms import FormTerms, OfDisplacement
from kanefe_fem.solids.forms import VOIGT
from kanefe_fem.solids.potential_flow import PotentialFlow, added_mass_of_flow
from kanefe_fem.solids.problem import Assembly, SolidProblem, solid_stress_stiffness
from kanefe_fem.solids.quadrature_assembly import QuadratureAssembly

Form = Callable[[FormTerms], Any]


@dataclass(frozen=True, eq=False)
class Forms:
    """Forms of a solid body instead of those of its materials; each is a function of `FormTerms`, given as `f` here.

    Parameters
    ----------
    stress : callable, optional
        ``stress(f, u)``: stress in Pa of a displacement u as a tensor, linear in u, such as of a graded or anisotropic
        material. Stiffness, stiffening by motion and stresses of a run follow from it; those of a run are computed
        with the moduli at the middle of each cell.
    stiffness : callable, optional
        ``stiffness(f)``: bilinear form in f.u and f.v, N/m. `f.stiffness` is that of the materials, or of `stress`.
    mass : callable, optional
        ``mass(f)``: bilinear form in the *scalar* functions f.p and f.q, kg: mass is the same in all directions.
        `f.mass` is that of the materials.
    damping : callable, optional
        ``damping(f)``: bilinear form in f.u and f.v, N s/m.
    geometric_stiffness : callable, optional
        ``geometric_stiffness(f, w)``: bilinear form in f.u and f.v, linear in a static displacement w, for stiffening
        by motion and preload. Default: ``grad(u) s(w) : grad(v)`` with the stress s of `stress` or of the materials;
        none where `stiffness` is given without it.
    added_mass : callable or PotentialFlow, optional
        ``added_mass(f)``: bilinear form in f.u and f.v, kg, of a fluid at rest around the body, such as
        ``m * dot(f.u, f.n) * dot(f.v, f.n) * f.ds("wet")`` with m in kg/m2. See `kanefe.bodies.wet_moments`.

    Raises
    ------
    ModelError
        If something is not a function, or nothing is given.

    Examples
    --------
    A bar whose modulus grows along x, and with water on one side:

    >>> def stress(f, u):
    ...     E = 1e9 * (1.0 + f.x[0])
    ...     return E * f.strain(u)                                    # a material without lateral contraction
    >>> def water(f):
    ...     return 50.0 * f.ufl.dot(f.u, f.n) * f.ufl.dot(f.v, f.n) * f.ds("wet")
    >>> forms = Forms(stress=stress, added_mass=water)
    """

    stress: OfDisplacement | None = None
    stiffness: Form | None = None
    mass: Form | None = None
    damping: Form | None = None
    geometric_stiffness: OfDisplacement | None = None
    added_mass: Form | PotentialFlow | None = None

    def __post_init__(self) -> None:
        given = {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) is not None}
        if not given:
            raise ModelError("Forms(...) has no form. Remedy: give one, or leave forms= out")
        for name, form in given.items():
            if not callable(form) and not (name == "added_mass" and isinstance(form, PotentialFlow)):
                raise ModelError(f"the form of the {_words(name)} is {form!r}. Remedy: a function that returns UFL")

    def describe(self) -> list[str]:
        """Return which forms are the user's (json-able)."""
        return [f.name for f in fields(self) if getattr(self, f.name) is not None]


def with_forms(
    model: FiniteElementModel,
    forms: Forms,
    assembly: Assembly | QuadratureAssembly,
    mesh: Mesh,
    materials: CellMaterials,
    thickness: float,
) -> FiniteElementModel:
    """Return the model of a solid with the matrices of the user's forms.

    Parameters
    ----------
    model : FiniteElementModel
        That of the materials.
    forms : Forms
    assembly : Assembly
        From which the model was made.
    mesh : Mesh
        Of the order of the displacement, in its own numbering.
    materials : CellMaterials
    thickness : float
        Of a plane body in m; 1 of a solid.

    Raises
    ------
    ModelError
        If a form is not UFL, is not symmetric, not positive, or resists a rigid motion, with size and remedy.
    """
    if not isinstance(assembly, Assembly):
        raise ModelError(
            f"{mesh.source} has cells of the shapes {', '.join(mesh.kinds)}, on which dolfinx assembles no forms. "
            f"Remedy: cells of one shape among {', '.join(_fenicsx.SHAPES)}"
        )
    _check_damping_of_materials(model, forms)
    problem = assembly.problem
    with _fenicsx.quiet(), _fenicsx.compiling(problem.fx):
        original = np.asarray(problem.mesh.topology.original_cell_index)
        terms = FormTerms(problem, mesh, materials.density[original], thickness, forms.stress)
        changed = {
            **_elastic(model, forms, problem, terms),
            **_inert(model, forms, problem, terms),
        }
    return replace(model, **changed, provenance={**model.provenance, "forms": forms.describe()})


def _check_damping_of_materials(model: FiniteElementModel, forms: Forms) -> None:
    """Raise a ModelError if the materials damp a stiffness or mass that a form replaces."""
    replaced = forms.stress is not None or forms.stiffness is not None
    proportional = model.damping is not None and forms.damping is None and (replaced or forms.mass is not None)
    if proportional or (replaced and (model.structural is not None or model.viscoelastic)):
        raise ModelError(
            "the damping of the materials (Rayleigh, loss factors, Prony series) is that of their own stiffness and "
            "mass, which forms replace. Remedy: materials without it, and Forms(damping=...) or damping= of the body"
        )


def _elastic(model: FiniteElementModel, forms: Forms, problem: SolidProblem, terms: FormTerms) -> dict[str, Any]:
    """Return stiffness, damping, geometric stiffness and moduli of the forms."""
    changed: dict[str, Any] = {}
    if forms.stress is not None:
        changed["elasticity"] = _moduli(problem, terms)
        changed["stress_stiffness"] = solid_stress_stiffness(problem, lambda w: terms.thickness * terms.stress(w))
    if forms.stiffness is not None or forms.stress is not None:
        form = terms.stiffness if forms.stiffness is None else forms.stiffness(terms)
        K = _matrix(problem, form, "stiffness" if forms.stiffness else "stress")
        changed["stiffness"] = check_stiffness(model, K, factorise)
        if forms.stress is None:  # those of the materials are of another body
            changed |= {"elasticity": None, "stress_stiffness": None}
    if forms.damping is not None:
        changed["damping"] = check_damping(model, _matrix(problem, forms.damping(terms), "damping"), factorise)
    if forms.geometric_stiffness is not None:
        changed["stress_stiffness"] = _geometric(problem, terms, forms.geometric_stiffness)
        check_geometric_stiffness(replace(model, stress_stiffness=changed["stress_stiffness"]))
    return changed


def _inert(model: FiniteElementModel, forms: Forms, problem: SolidProblem, terms: FormTerms) -> dict[str, Any]:
    """Return mass and added mass of the forms."""
    changed: dict[str, Any] = {}
    if forms.mass is not None and model.mass_field is not None:
        mass = check_mass(_matrix(problem, forms.mass(terms), "mass", is_scalar=True))
        changed["mass"] = sp.kron(mass, sp.identity(problem.element.dimension), format="csr")
        changed["mass_field"] = replace(model.mass_field, mass=mass)
    if isinstance(forms.added_mass, PotentialFlow):
        changed["added_mass"] = check_fluid(added_mass_of_flow(forms.added_mass, model, factorise), factorise)
    elif forms.added_mass is not None:
        changed["added_mass"] = check_fluid(_matrix(problem, forms.added_mass(terms), "added_mass"), factorise)
    return changed


def _geometric(problem: SolidProblem, terms: FormTerms, form: OfDisplacement) -> StressStiffness:
    """Return the function of a user's form of the geometric stiffness, which is compiled at the first call."""
    loaded = problem.displacement(np.zeros(len(problem.order_of_nodes) * problem.element.dimension))

    def geometric_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        with _fenicsx.quiet(), _fenicsx.compiling(problem.fx):
            loaded.x.array[:] = displacement
            return _matrix(problem, form(terms, loaded), "geometric_stiffness")

    return geometric_stiffness


def _moduli(problem: SolidProblem, terms: FormTerms) -> Elasticity:
    """Return the moduli at the middle of each cell, from the stress of unit strains."""
    ufl, d = problem.fx.ufl, problem.element.dimension
    numbers = []
    for a, b in VOIGT[d]:
        strain = np.zeros((d, d))
        strain[a, b] = strain[b, a] = 1.0 if a == b else 0.5
        stress = terms.stress(ufl.dot(ufl.as_matrix(strain.tolist()), terms.x))
        numbers += [stress[c, e] for c, e in VOIGT[d]]
    middle = problem.element.nodes.mean(axis=0)[None]
    expression = _fenicsx.compiled_expression(problem.fx, problem.mesh, ufl.as_vector(numbers), middle)
    original = np.asarray(problem.mesh.topology.original_cell_index)
    size = len(VOIGT[d])
    table = np.empty((len(original), size, size))
    table[original] = expression(len(original)).reshape(-1, size, size).transpose(0, 2, 1)
    return Elasticity(table if d == 3 else in_space(table), np.arange(len(table)))


def _matrix(problem: SolidProblem, form: Any, name: str, is_scalar: bool = False) -> sp.csr_matrix:
    """Return the matrix of a form in the order of the nodes of the body, (n, n) of a scalar one, else (n d, n d)."""
    fx, words = problem.fx, _words(name)
    functions = "f.p and f.q" if is_scalar else "f.u and f.v"
    remedy = f"Remedy: an integral that is linear in {functions}, such as ... * f.dx"
    if not isinstance(form, fx.ufl.Form):
        raise ModelError(f"the form of the {words} is {form!r}, not an integral. {remedy}")
    space = problem.scalar if is_scalar else problem.vector
    own = (fx.ufl.TestFunction(space), fx.ufl.TrialFunction(space))
    if tuple(form.arguments()) != own:
        raise ModelError(f"the form of the {words} is not one of the two functions {functions}. {remedy}")
    _, error = _fenicsx.load_ufl()
    try:
        compiled = fx.fem.form(form)
    except (ValueError, TypeError, error) as fault:
        raise ModelError(f"the form of the {words} cannot be assembled ({fault}). {remedy}") from fault
    return problem.scalar_matrix(compiled) if is_scalar else _fenicsx.assemble_matrix(fx, compiled)


def _words(name: str) -> str:
    return name.replace("_", " ")
