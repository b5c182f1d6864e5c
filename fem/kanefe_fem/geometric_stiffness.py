"""Geometric stiffness of solids: what the stress of a static displacement does to further displacements."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.finite_element_model import StressStiffness
from kanefe_fem import _fenicsx
from kanefe_fem.solid_forms import stiffness_degree
from kanefe_fem.solid_problem import SolidProblem


def solid_stress_stiffness(problem: SolidProblem) -> StressStiffness:
    """Return the function of a static displacement (N,) that gives the geometric stiffness (N, N) of its stress s.

    ``K_g = int grad(u) s : grad(v)`` is the same for each component of the displacement, so that a matrix of the
    scalar space, ``int grad(p) . s grad(q)``, is all that is assembled. Its form is compiled at the first call.

    Parameters
    ----------
    problem : SolidProblem
        2D or 3D; in 2D the stress is per width (times the thickness).
    """
    made: list[tuple[Any, Any]] = []
    dimension = problem.element.dimension

    def geometric_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        with _fenicsx.quiet(), _fenicsx.compiling():
            if not made:
                made.append(_form(problem))
            loaded, form = made[0]
            loaded.x.array[:] = displacement
            scalar = problem.scalar_matrix(form)
        return sp.kron(scalar, sp.identity(dimension), format="csr")

    return geometric_stiffness


def _form(problem: SolidProblem) -> tuple[Any, Any]:
    """Return the function that holds the static displacement, and the compiled form."""
    fx = problem.fx
    loaded = problem.displacement(np.zeros(len(problem.order_of_nodes) * problem.element.dimension))
    p, q = fx.ufl.TrialFunction(problem.scalar), fx.ufl.TestFunction(problem.scalar)
    # the points of the stiffness: then a strain that vanishes at all of them, as in a rigid turn, does no work at all
    degree = stiffness_degree(problem.element, problem.geometry)
    integrand = fx.ufl.inner(fx.ufl.dot(problem.stress(loaded), fx.ufl.grad(p)), fx.ufl.grad(q))
    return loaded, fx.fem.form(integrand * problem.measure(degree))
